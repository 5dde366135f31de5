"""The arena against the exact solution: two pucks on a line between two walls, in rationals.

A third puck rests beside the line until it is commanded, which must not disturb the other two.
"""

from bisect import bisect_right
from collections import namedtuple
from fractions import Fraction

from carom.msg import Contact
from geometry_msgs.msg import Twist
from harness import Carom, Client, assert_close, scene, seconds, wait_until

# Binary fractions throughout: the node starts from exactly these numbers.
WIDTH, RADIUS = Fraction(2), Fraction(1, 8)
MASSES = Fraction(1), Fraction(2)
START_X = Fraction(1, 2), Fraction(3, 2)
START_V = Fraction(3, 2), Fraction(-3, 4)
LEFT, RIGHT, RESTING = 1, 2, 3
COMMAND = (0.25, -0.125)
SCENE = f"""\
name: two pucks head-on, one at rest
walls: {{x: [0.0, {float(WIDTH)}], y: [0.0, 4.0]}}
pucks:
  - {{name: left, position: [{float(START_X[0])}, 0.5], velocity: [{float(START_V[0])}, 0.0],
     radius: {float(RADIUS)}, mass: {float(MASSES[0])}, id: {LEFT}}}
  - {{name: right, position: [{float(START_X[1])}, 0.5], velocity: [{float(START_V[1])}, 0.0],
     radius: {float(RADIUS)}, mass: {float(MASSES[1])}, id: {RIGHT}}}
  - {{name: resting, position: [0.5, 3.0], radius: 0.25, id: {RESTING}}}
"""
PUBLISH_RATE_HZ = 60
POSITION_TOLERANCE, TIME_TOLERANCE = 1e-8, 1e-12

# What happens at `time` between `ids`, and positions and velocities from then on.
Event = namedtuple("Event", "time ids approach impulse x v")


def next_event(event):
    """The next of: left at the left wall, right at the right wall, the two together."""
    (x1, x2), (v1, v2), (m1, m2) = event.x, event.v, MASSES
    options = []
    if v1 < 0:
        options.append(((x1 - RADIUS) / -v1, {LEFT, Contact.WALL}, -v1, -2 * m1 * v1, (-v1, v2)))
    if v2 > 0:
        gap = WIDTH - RADIUS - x2
        options.append((gap / v2, {RIGHT, Contact.WALL}, v2, 2 * m2 * v2, (v1, -v2)))
    if v1 > v2:
        impulse = 2 * m1 * m2 / (m1 + m2) * (v1 - v2)
        after = (v1 - impulse / m1, v2 + impulse / m2)
        options.append(((x2 - x1 - 2 * RADIUS) / (v1 - v2), {LEFT, RIGHT}, v1 - v2, impulse, after))
    (after_s, ids, approach, impulse, v), *others = sorted(options, key=lambda option: option[0])
    assert all(after_s < other[0] for other in others), "two contacts at once: choose other numbers"
    x = (x1 + v1 * after_s, x2 + v2 * after_s)
    return Event(event.time + after_s, ids, approach, impulse, x, v)


def exact_events(until_s):
    events = [Event(Fraction(0), set(), 0, 0, START_X, START_V)]
    while events[-1].time <= until_s:
        events.append(next_event(events[-1]))
    return events


def check_states(states, events):
    """Each message against the exact positions at its stamp."""
    times = [event.time for event in events]
    for message in states:
        ids = [circle.id for circle in message.circles]
        assert ids == [LEFT, RIGHT, RESTING], f"arena_states of {ids}"
        assert message.header.frame_id == "map", f"frame_id {message.header.frame_id!r}"
        stamp = message.header.stamp
        now = stamp.sec + Fraction(stamp.nanosec, 1_000_000_000)
        event = events[bisect_right(times, now) - 1]
        for circle, x, v in zip(message.circles, event.x, event.v):
            label = f"puck {circle.id} at {float(now)} s"
            assert_close(circle.x, x + v * (now - event.time), POSITION_TOLERANCE, f"x of {label}")
            assert_close(circle.y, 0.5, 0, f"y of {label}")


def check_contacts(messages, events):
    """From the first contact heard on, every one and only these, each at its exact time."""
    found = []
    for message in messages:
        late = [c.time for c in message.contacts if c.time > seconds(message.header.stamp) + 1e-9]
        assert not late, f"contacts at {late} in a message of {seconds(message.header.stamp)} s"
        found += message.contacts
    first = min(range(1, len(events)), key=lambda i: abs(events[i].time - found[0].time))
    for contact, event in zip(found, events[first:]):
        label = f"contact of {contact.a} and {contact.b} at {contact.time} s"
        assert {contact.a, contact.b} == event.ids, f"{label}: expected {event.ids}"
        assert contact.a != Contact.WALL, f"{label}: the wall is b"
        assert_close(contact.time, event.time, TIME_TOLERANCE, label)
        assert_close(contact.approach_speed, event.approach, 1e-12, f"approach speed, {label}")
        assert_close(contact.impulse, event.impulse, 1e-12, f"impulse, {label}")
        to_the_left = (contact.a, contact.b) in ((LEFT, Contact.WALL), (RIGHT, LEFT))
        assert_close(contact.normal_x, -1 if to_the_left else 1, 1e-15, f"normal, {label}")
    return len(found)


def check_rate(states):
    stamps = [seconds(message.header.stamp) for message in states]
    assert all(a < b for a, b in zip(stamps, stamps[1:])), "stamps of arena_states do not rise"
    rate_hz = (len(stamps) - 1) / (stamps[-1] - stamps[0])
    assert abs(rate_hz / PUBLISH_RATE_HZ - 1) <= 0.2, f"arena_states at {rate_hz} Hz"
    return rate_hz


def command(client, states):
    """Commands the resting puck until its state shows it; it then moves on a straight line."""
    publisher = client.node.create_publisher(Twist, "pucks/resting/cmd_vel", 10)
    twist = Twist()
    twist.linear.x, twist.linear.y = COMMAND

    def moving():
        return [m for m in states if (m.circles[2].vx, m.circles[2].vy) == COMMAND]

    at_rest = states[-1].circles[2]
    assert (at_rest.x, at_rest.y, at_rest.vx, at_rest.vy) == (0.5, 3.0, 0, 0), f"{at_rest}"
    wait_until(moving, "the commanded velocity in arena_states",
               each=lambda: publisher.publish(twist))
    wait_until(lambda: len(moving()) > PUBLISH_RATE_HZ, "a second of motion")
    first, last = moving()[0], moving()[-1]
    elapsed_s = seconds(last.header.stamp) - seconds(first.header.stamp)
    for axis, speed in zip("xy", COMMAND):
        moved = getattr(last.circles[2], axis) - getattr(first.circles[2], axis)
        assert_close(moved, speed * elapsed_s, POSITION_TOLERANCE, f"way of the puck along {axis}")


def main():
    with Carom(scene(SCENE)), Client(topics=["arena_states", "contacts"]) as client:
        states = client.inboxes["arena_states"].messages
        contacts = client.inboxes["contacts"].messages
        wait_until(lambda: states and sum(len(m.contacts) for m in contacts) >= 12, "12 contacts")
        command(client, states)
    events = exact_events(until_s=seconds(states[-1].header.stamp) + 1)
    check_states(states, events)
    count = check_contacts(contacts, events)
    rate_hz = check_rate(states)
    print(f"{len(states)} states at {rate_hz:.1f} Hz and {count} contacts as in the exact solution")


if __name__ == "__main__":
    main()
