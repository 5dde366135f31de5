"""Ten thousand circles at 10 Hz reach a subscriber with default settings, whole.

None may be lost. Other numbers by hand: `large.py CIRCLES RATE_HZ SECONDS DEPTH`. A hundred
thousand at 1 Hz are 57 parts, more than the ten that a queue keeps by default:
`large.py 100000 1 60 200`, with FASTDDS_BUILTIN_TRANSPORTS="DEFAULT?sockets_size=4MB".
"""

import sys
import time

from carom.msg import CircleStates
from harness import CHANGED, Carom, Client, nanoseconds, scene, wait_until

# Depth 10, reliable: what a script gets that asks for nothing else.
PUCKS, RATE_HZ, SECONDS, DEPTH = map(int, sys.argv[1:] or [10_000, 10, 60, 10])
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


def is_whole(got):
    """Whether the parts of a state are all there, once each."""
    numbers = [part for part, _, _ in sorted(got)]
    return numbers == list(range(got[0][1])) and sum(count for _, _, count in got) == PUCKS


def main():
    with Client(topics=()) as client:
        parts = Parts(client)
        with Carom(scene(SCENE)):
            wait_until(lambda: len(parts.by_stamp) > 2, "the first states", timeout_s=60.0)
            time.sleep(SECONDS)
        first, *stamps, last = sorted(parts.by_stamp)
        count = round((last - first) * RATE_HZ / 1e9) - 1
        whole = sum(is_whole(parts.by_stamp[stamp]) for stamp in stamps)
        print(f"{whole} of {count} states of {PUCKS} circles whole, {count - whole} lost")
        assert count > 0.95 * RATE_HZ * SECONDS - 2, f"{count} states: too slow"
        assert whole == count, "some were lost"


if __name__ == "__main__":
    main()
