"""The node comes, serves, goes at once by SIGINT or SIGTERM, and comes again; stopped, it goes on."""

import signal
import time

from harness import Carom, Client, wait_until
from rclpy.node import NodeNameNonExistentError

NODE = ("carom", "/")
SUBSCRIBED = {"/circle_states": "carom/msg/CircleStates"}
PUBLISHED = {
    "/corrected_velocities": "carom/msg/CircleVelocities",
    "/contacts": "carom/msg/Contacts",
}


def in_graph(node):
    return NODE in node.get_node_names_and_namespaces()


def has_topics(node):
    """The node is in the graph with its topics, each of one type."""
    try:
        subscribed = dict(node.get_subscriber_names_and_types_by_node(*NODE))
        published = dict(node.get_publisher_names_and_types_by_node(*NODE))
    except NodeNameNonExistentError:
        return False
    return all(subscribed.get(name) == [kind] for name, kind in SUBSCRIBED.items()) and all(
        published.get(name) == [kind] for name, kind in PUBLISHED.items())


def check_life(client, end):
    node = client.node
    with Carom("resolver") as carom:
        client.connect()
        wait_until(lambda: has_topics(node), "node, topics and types in the graph")
        assert client.ask(client.probe()).velocities, "not served"
        code, elapsed_s = carom.stop(end)
    assert code == 0, f"{end.name}: exit code {code}"
    assert elapsed_s < 2.0, f"{end.name}: took {elapsed_s} s to exit"
    wait_until(lambda: not in_graph(node), f"{end.name}: gone from the graph", timeout_s=2.0)


def check_stopped():
    """As by Ctrl-Z and `fg`: known clients are served afterwards, and new ones."""
    with Carom("resolver") as carom, Client() as client:
        client.connect()
        for _ in range(3):
            carom.process.send_signal(signal.SIGSTOP)
            time.sleep(0.2)
            carom.process.send_signal(signal.SIGCONT)
            assert client.ask(client.probe()).velocities, "not served after a stop"
        with Client() as late:
            late.connect()


def main():
    check_stopped()
    with Client() as client:
        for end in (signal.SIGINT, signal.SIGTERM, signal.SIGINT):
            check_life(client, end)


if __name__ == "__main__":
    main()
