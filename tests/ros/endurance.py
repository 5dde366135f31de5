"""A message each millisecond, for as long as is asked: the node's memory does not grow.

Thirty seconds in the suite; ten minutes by hand, with the environment that tests/ros.rs gives to a
script: CAROM_ENDURANCE_S=600 python tests/ros/endurance.py
"""

import os

from carom.msg import CircleVelocities, Contacts
from harness import Carom, Client, Last, next_stamp, paced, wait_until
from kilohertz import pair

RATE_HZ = 1000
DURATION_S = int(os.environ.get("CAROM_ENDURANCE_S", "30"))
# Until every buffer has been used once: DDS keeps some thousand messages, on a busy machine more.
WARM_UP_S = 15
# A leak of 32 bytes a message; a page or two come and go.
GROWTH_MAX_BYTES = 32 * RATE_HZ * (DURATION_S - WARM_UP_S) + 200_000


def measure(carom, client):
    """The node's memory at each second of messages."""
    memory = []
    for number in paced(RATE_HZ * DURATION_S, RATE_HZ):
        if number % RATE_HZ == 0:
            memory.append(carom.memory_bytes())
        stamp = client.publish(pair(number))
    return stamp, [*memory, carom.memory_bytes()]


def main():
    with Carom("resolver") as carom, Client(topics=()) as client:
        heard = [Last(client, CircleVelocities, "corrected_velocities"),
                 Last(client, Contacts, "contacts")]
        wait_until(lambda: all(last.count for last in heard), "the first answer",
                   each=lambda: client.publish(pair(0), stamp=next_stamp()))
        before = [last.count for last in heard]
        stamp, memory = measure(carom, client)
        wait_until(lambda: all(last.stamp == stamp for last in heard), "the last answer")
        counts = [last.count - count for last, count in zip(heard, before)]
        code, _ = carom.stop()
    growth = memory[-1] - memory[WARM_UP_S]
    every = max(1, DURATION_S // 20)
    print("MB, every", every, "s:", *(f"{bytes / 1e6:.2f}" for bytes in memory[::every]))
    each = growth / RATE_HZ / (DURATION_S - WARM_UP_S)
    print(f"{RATE_HZ * DURATION_S} messages, {counts} answers; after {WARM_UP_S} s the memory grew "
          f"by {growth} bytes, {each:.2f} a message")
    assert code == 0, f"exit code {code}"
    # Other scripts may run beside this one; what is lost then is no matter here.
    assert min(counts) > 0.5 * RATE_HZ * DURATION_S, f"answers: {counts}"
    assert growth < GROWTH_MAX_BYTES, f"memory grew by {growth} bytes"


if __name__ == "__main__":
    main()
