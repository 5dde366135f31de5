"""Bad circles are refused by name and the good ones of the same message served; bad scenes too."""

import re
import subprocess
from math import inf, nan

from harness import BINARY, TIMEOUT_S, Carom, Circle, Client, Heard, scene, wait_until
from rcl_interfaces.msg import Log
from rclpy.qos import QoSDurabilityPolicy, QoSProfile

LOG_QOS = QoSProfile(depth=1000, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
GOOD = [Circle(1, 0, 0, 1, 0, 1, 1), Circle(2, 2, 0, -1, 0, 1, 1)]
SWAPPED = {1: (-1.0, 0.0), 2: (1.0, 0.0)}
# Each would be in a contact of its own with a good circle, were it accepted: a wrong answer.
# The ids are found again in the log, so they look like nothing else there.
BAD = [
    (Circle(770001, nan, 1, 0, -1, 1, 1), "x"),
    (Circle(770002, 0, 0.5, 0, -1, 0, 1), "radius"),
    (Circle(770003, 0, 1, 0, -1, 1, 0), "mass"),
    (Circle(770004, 0, -1, 0, 1, 1, -1), "mass"),
    (Circle(770005, 2, 1, inf, -1, 1, 1), "vx"),
    (Circle(770006, 2, -1, 0, 1, 1, 1), "duplicate"),
    (Circle(770006, 2, -1.5, 0, 1, 1, 1), "duplicate"),
]


def check_messages():
    bad = [circle for circle, _ in BAD]
    with Carom("resolver") as carom, Client() as client:
        # Late, and told from the beginning all the same.
        log = Heard(client, Log, "/rosout", LOG_QOS)
        client.connect()
        mixed = client.ask([*bad[:3], GOOD[0], *bad[3:], GOOD[1]], "good pair among bad circles")
        assert mixed.velocities == SWAPPED, f"good pair among bad circles: {mixed.velocities}"
        for circle, word in BAD:
            name, reason = rf"\b{circle.id}\b", rf"\b{word}\b"
            line = carom.wait_for_line("ERROR", "circle_states", name, reason)
            wait_until(lambda: [entry for entry in log if entry.msg in line],
                       f"/rosout says what stderr does: {line}")
        said = {(entry.level, entry.name) for entry in log if "circle" in entry.msg}
        assert said == {(Log.ERROR, "carom")}, said
        assert [entry for entry in log if entry.level == Log.INFO], log
        client.expect_no_answer(bad, "all circles bad")
        good = client.ask(GOOD, "good message after bad ones")
        assert good.velocities == SWAPPED, f"good message after bad ones: {good.velocities}"
        assert carom.alive(), "the node has exited"


def check_refused(arguments, *patterns):
    """The node does not start: exit code 2 and one line on stderr that says why."""
    result = subprocess.run([BINARY, "run", *map(str, arguments)], stdin=subprocess.DEVNULL,
                            capture_output=True, text=True, timeout=TIMEOUT_S)
    assert result.returncode == 2, f"{arguments}: exit {result.returncode}\n{result.stderr}"
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1, f"{arguments}: not one line:\n{result.stderr}"
    missing = [pattern for pattern in patterns if not re.search(pattern, lines[0])]
    assert not missing, f"{arguments}: {lines[0]!r} does not name {missing}"


def main():
    check_messages()
    path = scene("name: misspelt\n\nrestitutoin: 0.5\n", "misspelt.yaml")
    check_refused([path], re.escape(str(path)), r"(:|line )3\b", "restitutoin")
    check_refused(["no_such_scene"], "no_such_scene")


if __name__ == "__main__":
    main()
