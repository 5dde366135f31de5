"""SIGKILL of either side: the other one goes on, and who comes back is served.

A killed process says no goodbye. A dead client stays in the node's books for the lease of 20 s that
Fast DDS gives itself: until then it costs the others nothing.
"""

import os
import signal
import subprocess
import sys
import time

from harness import Carom, Circle, Client, paced, scene, wait_until

STALE_AFTER_S = 0.5
# More than DDS holds for a reader that does not acknowledge, unless it is told to.
MESSAGES, RATE_HZ = 9_000, 1500
GROWTH_MAX_BYTES = 20_000_000
LEFT, RIGHT = Circle(1, 0, 0, 1, 0, 1, 1), Circle(2, 2, 0, -1, 0, 1, 1)


class Child:
    """This script as a client of its own, that publishes circle 1 until it is killed."""

    def __enter__(self):
        self.process = subprocess.Popen([sys.executable, __file__, "child"], text=True,
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE)
        assert self.process.stdout.readline() == "served\n", "the child is not served"
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()


def child():
    parent = os.getppid()
    with Client() as client:
        client.connect()
        print("served", flush=True)
        # Should the parent die first, nobody would end this process.
        while os.getppid() == parent:
            client.publish([LEFT])
            time.sleep(0.002)


def velocities(client, circle, what):
    """The answer to a circle, less the probe that says that it was heard."""
    probe = client.probe()
    answer = client.ask([circle, *probe], what).velocities
    return {key: value for key, value in answer.items() if key not in {c.id for c in probe}}


def check_client_killed(carom, client):
    """The others are served on, the dead one's circle goes stale, and a new client is served."""
    with Child():
        wait_until(lambda: velocities(client, RIGHT, "beside the child") == {1: (-1, 0), 2: (1, 0)},
                   "the child's circle")
    memory = carom.memory_bytes()
    wait_until(lambda: velocities(client, RIGHT, "after the child") == {}, "circle 1 goes stale",
               timeout_s=STALE_AFTER_S + 5.0)
    stamps = [client.publish(client.probe()) for _ in paced(MESSAGES, RATE_HZ)]
    wait_until(lambda: client.answered(stamps[-1]), "the last answer beside a dead client")
    answered, growth = sum(map(client.answered, stamps)), carom.memory_bytes() - memory
    print(f"beside a dead client: {answered} of {MESSAGES} answered, memory {growth:+} bytes")
    # What a busy machine loses is no matter here.
    assert answered > 0.9 * MESSAGES, f"{answered} of {MESSAGES} answered beside a dead client"
    assert growth < GROWTH_MAX_BYTES, f"{growth} bytes more with a dead client"
    assert not any("window" in line for line in carom.lines), "an answer was held back"
    with Client() as late:
        late.connect()


def check_node_killed(client, text):
    """The same client is served by a new node of the same name."""
    for life in range(2):
        start = time.monotonic()
        with Carom(scene(text)) as carom:
            client.connect()
            print(f"node {life}: served after {time.monotonic() - start:.2f} s")
            assert client.ask(client.probe()).velocities
            assert carom.stop(signal.SIGKILL)[0] == -signal.SIGKILL


def main():
    text = f"name: short memory\nnode: {{stale_after_s: {STALE_AFTER_S}}}\n"
    with Client() as client:
        check_node_killed(client, text)
        with Carom(scene(text)) as carom:
            client.connect()
            check_client_killed(carom, client)


if __name__ == "__main__":
    child() if sys.argv[1:] == ["child"] else main()
