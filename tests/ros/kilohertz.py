"""A message each millisecond for ten seconds, every one a contact, every one answered rightly."""

import time

from harness import Carom, Circle, Client, paced, wait_until

RATE_HZ, DURATION_S = 1000, 10
COUNT = RATE_HZ * DURATION_S


def speed(number):
    """A speed of its own for each message, exact in float64."""
    return 1.0 + number / 16384


def pair(number):
    return [Circle(1, 0, 0, speed(number), 0, 1, 1), Circle(2, 2, 0, -1, 0, 1, 1)]


def publish_paced(client):
    start = time.monotonic()
    stamps = [client.publish(pair(number)) for number in paced(COUNT, RATE_HZ)]
    return stamps, COUNT / (time.monotonic() - start)


def check(client, stamps):
    """Equal masses, head-on: the two swap their velocities, to the last bit."""
    inbox = client.inboxes["corrected_velocities"]
    lost = [number for number, stamp in enumerate(stamps) if stamp not in inbox.by_stamp]
    assert not lost, f"{len(lost)} of {COUNT} without an answer, the first: {lost[:10]}"
    for number, stamp in enumerate(stamps):
        answer = client.answer(stamp).velocities
        expected = {1: (-1.0, 0.0), 2: (speed(number), 0.0)}
        assert answer == expected, f"message {number}: {answer}, expected {expected}"


def main():
    # Without a subscription to contacts: this measures the node, not the reader in Python.
    with Carom("resolver"), Client(topics=["corrected_velocities"]) as client:
        client.connect()
        stamps, rate_hz = publish_paced(client)
        answered = client.inboxes["corrected_velocities"].by_stamp
        try:
            wait_until(lambda: stamps[-1] in answered, "the last answer")
        finally:
            found = sum(stamp in answered for stamp in stamps)
            print(f"{COUNT} messages at {rate_hz:.1f} Hz, {COUNT - found} lost")
        check(client, stamps)
    assert rate_hz > 0.9 * RATE_HZ, f"published at {rate_hz:.1f} Hz: this machine is too busy"


if __name__ == "__main__":
    main()
