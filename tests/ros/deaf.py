"""A subscriber that acknowledges nothing silences nobody for long.

RustDDS matches by the name of a topic alone. A subscriber of another type is thus sent everything,
on a DDS that looks at types too and so never acknowledges it. After 32 768 messages RustDDS sends
no more: the node opens the publisher anew.
"""

from carom.msg import CircleVelocities
from harness import Carom, Client, Last, paced, wait_until
from std_msgs.msg import String

MESSAGES, RATE_HZ = 34_000, 2500
GROWTH_MAX_BYTES = 40_000_000


def main():
    topic = "corrected_velocities"
    with Carom("resolver") as carom, Client(topics=()) as client, Client(topics=()) as deaf:
        last = Last(client, CircleVelocities, topic)
        wait_until(lambda: last.count, "the first answer",
                   each=lambda: client.publish(client.probe()))
        deaf.node.create_subscription(String, topic, print, 10)
        line = carom.wait_for_line("ERROR", "reads std_msgs/msg/String", topic, "CircleVelocities")
        memory, probe = carom.memory_bytes(), client.probe()
        stamps = [client.publish(probe) for _ in paced(MESSAGES, RATE_HZ)]
        carom.wait_for_line("ERROR", topic, "send window full")
        growth, count = carom.memory_bytes() - memory, last.count
        wait_until(lambda: last.count > count and last.stamp > stamps[-1], "an answer after it",
                   each=lambda: client.publish(probe))
    print(f"{count} of {MESSAGES} answered before the publisher was opened anew, memory "
          f"{growth:+} bytes\n{line}")
    assert growth < GROWTH_MAX_BYTES, f"{growth} bytes"


if __name__ == "__main__":
    main()
