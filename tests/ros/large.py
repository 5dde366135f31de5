"""Ten thousand circles at 10 Hz reach a subscriber with default settings, whole.

A reader that the machine holds up for the tenth of a second that its queue lasts loses some,
whoever sends: so a try that lost is made again, twice at most. A minute, and other numbers, by
hand: `large.py CIRCLES RATE_HZ SECONDS DEPTH`. A hundred thousand at 1 Hz are 113 parts, more than
the ten that a queue keeps by default: `large.py 100000 1 60 200`, with
FASTDDS_BUILTIN_TRANSPORTS="DEFAULT?sockets_size=4MB".
"""

import sys
import time

from carom.msg import CircleStates
from harness import CHANGED, Carom, Client, nanoseconds, scene, wait_until

# Depth 10, reliable: what a script gets that asks for nothing else.
PUCKS, RATE_HZ, SECONDS, DEPTH = map(int, sys.argv[1:] or [10_000, 10, 25, 10])
TRIES = 3
SIDE = PUCKS ** 0.5
SCENE = f"""
name: many
walls: {{x: [0, {SIDE}], y: [0, {SIDE}]}}
batches:
  - {{name: gas, count: {PUCKS}, seed: 1, radius: 0.2, speed: 0.1}}
node: {{publish_rate_hz: {RATE_HZ}}}
"""


class Parts:
    """The parts of all states, by stamp."""

    def __init__(self, client):
        self.by_stamp = {}
        client.node.create_subscription(CircleStates, "arena_states", self.store, DEPTH)

    def store(self, message):
        with CHANGED:
            self.by_stamp.setdefault(nanoseconds(message.header.stamp), []).append(
                (message.part, message.parts, len(message.circles)))
            CHANGED.notify_all()


def lost(parts):
    """What is not whole of what was heard, in words; nothing if all is."""
    stamps = sorted(parts.by_stamp)[1:-1]
    if len(stamps) < 0.95 * RATE_HZ * SECONDS - 2:
        return f"{len(stamps)} states"
    steps = {b - a for a, b in zip(stamps, stamps[1:])}
    if any(abs(step - 1e9 / RATE_HZ) >= 2 for step in steps):
        return f"a state is missing: {steps}"
    for stamp in stamps:
        got = sorted(parts.by_stamp[stamp])
        count = got[0][1]
        if ([part for part, _, _ in got] != list(range(count))
                or sum(circles for _, _, circles in got) != PUCKS):
            return f"parts are missing at {stamp}: {got}"
    print(f"{len(stamps)} states of {PUCKS} circles, in {count} parts each: none lost")
    return None


def attempt():
    with Client(topics=()) as client:
        parts = Parts(client)
        with Carom(scene(SCENE)):
            wait_until(lambda: len(parts.by_stamp) > 2, "the first states", timeout_s=60.0)
            time.sleep(SECONDS)
        return lost(parts)


def main():
    for _ in range(TRIES):
        trouble = attempt()
        if trouble is None:
            return
        print(trouble)
    sys.exit(f"each of {TRIES} tries lost some")


if __name__ == "__main__":
    main()
