"""Twelve participants in one domain on one host, and three nodes that start at one instant.

RustDDS announces itself to twelve on this host, the most that it promises; a thirteenth, which is
on Fast DDS and announces itself to more, is served too.
"""

from contextlib import ExitStack

from harness import Carom, CircleVelocities, Client, wait_until

CLIENTS = 11
AT_ONCE, ROUNDS = 3, 3


def check_crowd():
    """All are served, those first too after the last has come."""
    with Carom("resolver") as carom, ExitStack() as stack:
        clients = [stack.enter_context(Client()) for _ in range(CLIENTS)]
        for client in [*clients, *clients]:
            client.connect()
        thirteenth = stack.enter_context(Client()).connect()
        for client in [*clients, thirteenth]:
            assert set(client.ask(client.probe()).velocities) == {c.id for c in client.probe()}
        with Carom("resolver", "--ros-args", "-r", "__node:=late") as late:
            late.wait_for_line("WARN", "participant 14", "ROS_DOMAIN_ID")
        assert carom.alive()


def check_at_once(client, subscription, turn):
    """A node that starts beside others finds and is found, in each of its endpoints."""
    names = {f"node_{turn}_{number}" for number in range(AT_ONCE)}

    def is_complete():
        return (client.publisher.get_subscription_count() == AT_ONCE
                and subscription.get_publisher_count() == AT_ONCE
                and names <= set(client.node.get_node_names()))

    with ExitStack() as nodes:
        for name in names:
            nodes.enter_context(Carom("resolver", "--ros-args", "-r", f"__node:={name}"))
        wait_until(is_complete, f"{AT_ONCE} nodes that start at once", timeout_s=20.0)
    wait_until(lambda: client.publisher.get_subscription_count() == 0, "all nodes gone")


def main():
    check_crowd()
    with Client(topics=()) as client:
        subscription = client.node.create_subscription(
            CircleVelocities, "corrected_velocities", lambda _: None, 10)
        for turn in range(ROUNDS):
            check_at_once(client, subscription, turn)


if __name__ == "__main__":
    main()
