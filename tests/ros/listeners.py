"""Share of one core that an arena of 100 pucks at 60 Hz takes, by what is listened to."""

import time

from carom.msg import CircleStates, Contacts, ErrorReport
from visualization_msgs.msg import MarkerArray

from harness import Carom, Client, Heard, cpu_seconds, scene, wait_until

SCENE = """
node: {publish_rate_hz: 60}
walls: {x: [0, 6], y: [0, 6]}
batches:
  - {name: puck, count: 100, seed: 1, radius: 0.1, mass: 0.5, speed: 1.0}
"""
TOPICS = {
    "arena_states": CircleStates,
    "contacts": Contacts,
    "markers": MarkerArray,
    "error_report": ErrorReport,
}
SECONDS = 10.0
ROUNDS = 3
SILENT_MAX = 0.03


def share(carom):
    """CPU time over wall time, both of the same interval."""
    wall, cpu = time.monotonic(), cpu_seconds(carom.process.pid)
    time.sleep(SECONDS)
    return (cpu_seconds(carom.process.pid) - cpu) / (time.monotonic() - wall)


def heard_by(topics):
    """The shares of `ROUNDS` runs in which these topics are heard."""
    shares = []
    for _ in range(ROUNDS):
        with Carom(scene(SCENE)) as carom, Client(topics=()) as client:
            inboxes = [Heard(client, TOPICS[topic], topic) for topic in topics]
            carom.wait_for_line("100 pucks")
            wait_until(lambda: all(inboxes), f"messages on {topics}", each=lambda: None)
            shares.append(share(carom))
    return sorted(shares)


def main():
    silent = heard_by([])
    middle = silent[len(silent) // 2]
    print(f"nobody listens     {middle:.2%}  ({silent[0]:.2%} to {silent[-1]:.2%})", flush=True)
    for topic in TOPICS:
        shares = heard_by([topic])
        print(f"{topic:18} {shares[len(shares) // 2]:.2%}  "
              f"({shares[0]:.2%} to {shares[-1]:.2%})", flush=True)
    assert middle < SILENT_MAX, f"nobody listens, and it takes {middle:.2%} of a core"


main()
