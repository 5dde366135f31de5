"""The node's name, its namespace, its topics and services, as `--ros-args` and files rename them."""

from contextlib import ExitStack

from carom.msg import CircleStates, CircleVelocities
from harness import QOS, Carom, Client, Heard, circle_states, next_stamp, wait_until


def topics_of(client, name, namespace, wanted):
    """All topics that a node publishes, as soon as the wanted ones are known."""
    def found():
        if (name, namespace) not in client.node.get_node_names_and_namespaces():
            return None
        published = client.node.get_publisher_names_and_types_by_node(name, namespace)
        topics = {topic for topic, _ in published}
        return topics if wanted <= topics else None
    return wait_until(found, f"{namespace} {name} in the graph with {wanted}", timeout_s=30.0)


def check_three_side_by_side(client):
    """Three arenas that share a domain and disturb nothing of each other."""
    spaces = ["/one", "/two", "/three/deep"]
    with ExitStack() as nodes:
        for space in spaces:
            nodes.enter_context(Carom("break_shot", "--ros-args", "-r", f"__ns:={space}"))
        for space in spaces:
            wanted = {f"{space}/arena_states", f"{space}/contacts", "/clock"}
            topics = topics_of(client, "carom", space, wanted)
            assert "/arena_states" not in topics, topics


def check_rules(client):
    rules = ["-r", "__node:=referee", "-r", "corrected_velocities:=~/answers",
             "-r", "referee:circle_states:=/robots", "-r", "other:contacts:=/wrong"]
    answers = Heard(client, CircleVelocities, "/referee/answers")
    publisher = client.node.create_publisher(CircleStates, "/robots", QOS)
    with Carom("resolver", "--ros-args", *rules, "--"):
        topics_of(client, "referee", "/", {"/referee/answers", "/contacts"})
        wait_until(lambda: answers, "an answer on the renamed topic", each=lambda: (
            publisher.publish(circle_states(client.probe(), "map", next_stamp()))))


def check_services(client):
    with Carom("resolver", "--ros-args", "-r", "__ns:=/a", "-r", "~/list_parameters:=/all") as carom:
        def found():
            if ("carom", "/a") not in client.node.get_node_names_and_namespaces():
                return None
            services = client.node.get_service_names_and_types_by_node("carom", "/a")
            return dict(services) if len(services) >= 6 else None
        services = wait_until(found, "six services")
        assert services["/all"] == ["rcl_interfaces/srv/ListParameters"], services
        assert services["/a/carom/get_parameters"] == ["rcl_interfaces/srv/GetParameters"], services
        assert carom.alive()


def main():
    with Client() as client:
        check_rules(client)
        check_services(client)
        check_three_side_by_side(client)


if __name__ == "__main__":
    main()
