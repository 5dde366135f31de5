"""Messages at ten times the rate that the node can take: the latest wins, the rest is counted.

Meanwhile memory stays bounded, services answer, and SIGINT ends it at once.
"""

import threading
import time
from contextlib import contextmanager

from carom.msg import CircleVelocities, ErrorReport
from harness import (
    Carom, Circle, Client, Heard, Last, circle_states, next_stamp, paced, wait_until,
)
from parameters import Parameters
from rclpy.serialization import serialize_message

# All in contact with all: a small message and much work.
CIRCLES = [Circle(1 + k, 0.001 * k, 0.001 * (k * k % 97), 0.1 * (60 - k), 0, 1, 1)
           for k in range(120)]
TIMES, FLOOD_S = 10, 5
GROWTH_MAX_BYTES = 40_000_000
SERVICE_MAX_S = 2.0


class Flood:
    """Publishes one message again and again, each time with a stamp of its own."""

    def __init__(self, client):
        self.publisher, self.sent, self.stamp, self.rate_hz = client.publisher, 0, None, 0.0
        self.bytes = bytearray(serialize_message(circle_states(CIRCLES, "map", 0)))

    def send(self):
        self.stamp = next_stamp()
        self.bytes[4:8] = (self.stamp // 10**9).to_bytes(4, "little")
        self.bytes[8:12] = (self.stamp % 10**9).to_bytes(4, "little")
        self.publisher.publish(bytes(self.bytes))
        self.sent += 1

    def run(self, rate_hz, time_s):
        start, before = time.monotonic(), self.sent
        for _ in paced(int(rate_hz * time_s), rate_hz):
            self.send()
        self.rate_hz = (self.sent - before) / (time.monotonic() - start)

    @contextmanager
    def beside(self, rate_hz, time_s):
        thread = threading.Thread(target=self.run, args=(rate_hz, time_s))
        thread.start()
        yield
        thread.join()


def capacity_hz(flood, last):
    """Messages that the node answers in a second, one after another."""
    count, start = 0, time.monotonic()
    while time.monotonic() < start + 2.0:
        flood.send()
        wait_until(lambda: last.stamp == flood.stamp, "an answer", period_s=1.0)
        count += 1
    return count / (time.monotonic() - start)


def check_control(parameters, memory_bytes, times):
    """A service call now and then, and how large the node is."""
    memory = []
    for _ in range(times):
        start = time.monotonic()
        assert parameters.get("stale_after_s") == [0.5], "a parameter during the flood"
        memory.append((time.monotonic() - start, memory_bytes()))
        time.sleep(0.5)
    return max(call for call, _ in memory), max(size for _, size in memory)


def main():
    with Carom("resolver") as carom, Client(topics=()) as client:
        last = Last(client, CircleVelocities, "corrected_velocities")
        reports = Heard(client, ErrorReport, "error_report")
        flood, parameters = Flood(client), Parameters(client)
        wait_until(lambda: last.count and reports, "the first answer", each=flood.send)
        able_hz = capacity_hz(flood, last)
        before = reports[-1].dropped_in, flood.sent - last.count, carom.memory_bytes()
        with flood.beside(TIMES * able_hz, FLOOD_S):
            slowest_s, memory = check_control(parameters, carom.memory_bytes, FLOOD_S)
        wait_until(lambda: last.stamp == flood.stamp, "the answer to the last message")
        lost = flood.sent - last.count - before[1]
        wait_until(lambda: reports[-1].dropped_in - before[0] == lost,
                   f"{lost} dropped, not {reports[-1].dropped_in - before[0]}")
        growth = memory - before[2]
        print(f"able {able_hz:.0f} Hz, flooded at {flood.rate_hz:.0f} Hz: {lost} dropped and "
              f"counted, memory {growth:+} bytes, slowest service call {slowest_s:.3f} s")
        assert lost > 0 and flood.rate_hz > 0.5 * TIMES * able_hz, "that was no flood"
        assert growth < GROWTH_MAX_BYTES, f"memory grew by {growth} bytes"
        assert slowest_s < SERVICE_MAX_S, f"a service call took {slowest_s} s"
        # Longer than the bound: an end that waits for the end of the flood is none.
        with flood.beside(TIMES * able_hz, 5.0):
            time.sleep(1.0)
            code, elapsed_s = carom.stop()
        print(f"SIGINT in the flood: exit code {code} after {elapsed_s:.3f} s")
        assert code == 0 and elapsed_s < 2.0, f"exit code {code} after {elapsed_s} s"


if __name__ == "__main__":
    main()
