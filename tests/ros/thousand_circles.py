"""A thousand circles in one message against the vector method in its seven steps, all pairs.

Overlaps are in disjoint pairs, so that the answer does not depend on an order.
"""

import random
from math import hypot, pi, sqrt

from harness import Carom, Circle, Client, assert_close

COUNT, PAIRS, SEED = 1000, 300, 20
AREA_FRACTION = 0.3
TOLERANCE = 1e-12


def touch(a, b):
    return hypot(b.x - a.x, b.y - a.y) <= a.radius + b.radius


class Table:
    """Random circles on a square that they fill to AREA_FRACTION."""

    def __init__(self):
        self.random = random.Random(SEED)
        self.radii = [self.random.uniform(0.05, 0.15) for _ in range(COUNT)]
        self.side = sqrt(pi * sum(r * r for r in self.radii) / AREA_FRACTION)
        self.circles = []

    def circle(self, x, y):
        number, draw = len(self.circles), self.random.uniform
        return Circle(number + 1, x, y, draw(-1, 1), draw(-1, 1), self.radii[number], draw(0.5, 5))

    def place(self, propose, allowed):
        """Adds the first proposed circle that touches only the circles allowed."""
        while True:
            new = propose()
            if all(other in allowed or not touch(new, other) for other in self.circles):
                self.circles.append(new)
                return new

    def anywhere(self):
        return self.circle(self.random.uniform(0, self.side), self.random.uniform(0, self.side))

    def beside(self, partner):
        """A circle that overlaps its partner by 0.1 % to 15 % of the touching distance."""
        distance = (partner.radius + self.radii[len(self.circles)]) * self.random.uniform(.85, .999)
        x, y = self.random.uniform(-1, 1), self.random.uniform(-1, 1)
        scale = distance / hypot(x, y)
        return self.circle(partner.x + x * scale, partner.y + y * scale)


def random_circles():
    """All pairs first: a partner needs room beside its circle."""
    table = Table()
    for _ in range(PAIRS):
        partner = table.place(table.anywhere, ())
        table.place(lambda: table.beside(partner), (partner,))
    while len(table.circles) < COUNT:
        table.place(table.anywhere, ())
    return table.circles


def seven_steps(a, b):
    """Velocities after a contact; None if it does not approach (Berchek, steps 1 to 7)."""
    nx, ny = b.x - a.x, b.y - a.y
    length = hypot(nx, ny)
    nx, ny = nx / length, ny / length
    tx, ty = -ny, nx
    an, at = nx * a.vx + ny * a.vy, tx * a.vx + ty * a.vy
    bn, bt = nx * b.vx + ny * b.vy, tx * b.vx + ty * b.vy
    if an - bn <= 0:
        return None
    total = a.mass + b.mass
    an_after = (an * (a.mass - b.mass) + 2 * b.mass * bn) / total
    bn_after = (bn * (b.mass - a.mass) + 2 * a.mass * an) / total
    return {a.id: (an_after * nx + at * tx, an_after * ny + at * ty),
            b.id: (bn_after * nx + bt * tx, bn_after * ny + bt * ty)}


def reference(circles):
    velocities, contacts = {}, set()
    for index, a in enumerate(circles):
        for b in circles[index + 1:]:
            after = seven_steps(a, b) if touch(a, b) else None
            if after:
                assert not velocities.keys() & after.keys(), "the pairs are not disjoint"
                velocities.update(after)
                contacts.add(frozenset(after))
    return velocities, contacts


def main():
    circles = random_circles()
    velocities, contacts = reference(circles)
    assert len(contacts) > PAIRS / 3, f"only {len(contacts)} contacts to check"
    with Carom("resolver"), Client() as client:
        answer = client.connect().ask(circles, "a thousand circles")
    found = [frozenset((c.a, c.b)) for c in answer.contacts]
    assert len(found) == len(contacts), f"{len(found)} contacts, expected {len(contacts)}"
    assert set(found) == contacts, f"other contacts: {set(found) ^ contacts}"
    assert answer.velocities.keys() == velocities.keys(), "velocities of other circles"
    for identity, expected in velocities.items():
        for actual, value in zip(answer.velocities[identity], expected):
            assert_close(actual, value, TOLERANCE, f"velocity of circle {identity}")
    print(f"{len(contacts)} contacts among {COUNT} circles, all within {TOLERANCE}")


if __name__ == "__main__":
    main()
