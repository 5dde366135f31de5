"""The pure resolver against values worked by hand in rationals.

The oblique cases share the 3-4-5 normal n = (3/5, 4/5): centres (0, 0) and (3, 4), radii 2 and 3.
With v1 = (1, 2) and v2 = (-1, 1/2): v1.n = 11/5, v2.n = -1/5, approach a = 12/5. The impulse is
J = (1 + e) mu a with mu = m1 m2 / (m1 + m2); v1' = v1 - J n / m1, v2' = v2 + J n / m2; the loss
is (1 - e^2) mu a^2 / 2.
"""

from fractions import Fraction
from math import inf, nextafter

from harness import Carom, Circle, Client, assert_close, scene, seconds

# A few units in the last place of the largest values that occur.
TOLERANCE = 2e-15


def oblique(m1, m2, v2=(-1, "1/2")):
    return [Circle(1, 0, 0, 1, 2, 2, m1),
            Circle(2, 3, 4, *(float(Fraction(v)) for v in v2), 3, m2)]


def contact(approach_speed, impulse, energy_loss, normal=("3/5", "4/5"), point=("6/5", "8/5")):
    return {"normal_x": normal[0], "normal_y": normal[1], "point_x": point[0], "point_y": point[1],
            "gap": 0, "approach_speed": approach_speed, "impulse": impulse,
            "energy_loss": energy_loss}


HEAD_ON = [Circle(1, 0, 0, 1, 0, 1, 1), Circle(2, 2, 0, -1, 0, 1, 1)]

# name, circles, v1', v2', contact
ELASTIC = [
    ("head-on", HEAD_ON, (-1, 0), (1, 0), contact(2, 2, 0, normal=(1, 0), point=(1, 0))),
    ("oblique, masses 1 and 1", oblique(1, 1),
     ("-11/25", "2/25"), ("11/25", "121/50"), contact("12/5", "12/5", 0)),
    ("oblique, masses 1 and 3", oblique(1, 3),
     ("-29/25", "-22/25"), ("-7/25", "73/50"), contact("12/5", "18/5", 0)),
    ("oblique, mass 2 and fixed", oblique(2, inf, v2=(0, 0)),
     ("-41/25", "-38/25"), (0, 0), contact("11/5", "44/5", 0)),
]
HALF_ELASTIC = [
    ("restitution 1/2", oblique(1, 1),
     ("-2/25", "14/25"), ("2/25", "97/50"), contact("12/5", "9/5", "27/25")),
]
SILENT = [
    ("overlapping, separating", [Circle(1, 0, 0, -1, 0, 1, 1), Circle(2, 1.5, 0, 1, 0, 1, 1)]),
    ("touching, same velocity", [Circle(1, 0, 0, 1, 1, 1, 1), Circle(2, 2, 0, 1, 1, 1, 1)]),
    ("one unit in the last place apart",
     [Circle(1, 0, 0, 1, 0, 1, 1), Circle(2, nextafter(2, 3), 0, -1, 0, 1, 1)]),
]


def check(answer, name, v1, v2, expected):
    assert list(answer.velocities) == [1, 2], f"{name}: velocities of {list(answer.velocities)}"
    for identity, velocity in ((1, v1), (2, v2)):
        for axis, (actual, value) in enumerate(zip(answer.velocities[identity], velocity)):
            label = f"{name}: v{'xy'[axis]} of circle {identity}"
            assert_close(actual, Fraction(value), TOLERANCE, label)
    (found,) = answer.contacts
    # a and b may be given either way round; the normal, and only it, turns with them.
    assert {found.a, found.b} == {1, 2}, f"{name}: contact of {found.a} and {found.b}"
    turn = 1 if found.a == 1 else -1
    for field, value in expected.items():
        sign = turn if field.startswith("normal") else 1
        assert_close(getattr(found, field), sign * Fraction(value), TOLERANCE, f"{name}: {field}")
    # At today's date the spacing of float64 seconds is 2.4e-7.
    assert_close(found.time, seconds(answer.header.stamp), 1e-15, f"{name}: time")


def check_cases(client, cases):
    for name, circles, *expected in cases:
        check(client.ask(circles, name), name, *expected)


def check_header(client):
    """Stamp and frame come back as they went out, whatever the clock of the node says."""
    stamp = 12_500_000_001
    answer = client.ask(HEAD_ON, "old stamp", frame="table", stamp=stamp)
    assert answer.header.frame_id == "table", f"frame_id {answer.header.frame_id!r}"
    header = client.inboxes["contacts"].by_stamp[stamp][0].header
    assert header == answer.header, f"header of contacts: {header}"
    assert_close(answer.contacts[0].time, 12.500000001, 1e-15, "time of the contact")


def main():
    with Client() as client:
        with Carom("resolver"):
            client.connect()
            check_cases(client, ELASTIC)
            check_header(client)
            for name, circles in SILENT:
                client.expect_no_answer(circles, name)
        with Carom(scene("name: half elastic\nrestitution: 0.5\npucks: []\n")):
            client.connect()
            check_cases(client, HALF_ELASTIC)


if __name__ == "__main__":
    main()
