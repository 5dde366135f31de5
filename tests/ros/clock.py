"""/clock has one type and tells the arena's time; a resolver can live by it."""

import time

from harness import QOS, Carom, Circle, Client, Heard, seconds, wait_until
from parameters import Parameters
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from simulation import OK, PAUSED, Simulation

CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


def times_of(client):
    """All times told on /clock."""
    return Heard(client, Clock, "/clock", CLOCK, of=lambda message: seconds(message.clock))


def check_arena(client):
    times = times_of(client)
    with Carom("break_shot", "--rate", "2"):
        wait_until(lambda: len(times) > 60, "60 times")
        kinds = [types for name, types in client.node.get_topic_names_and_types()
                 if name == "/clock"]
        assert kinds == [["rosgraph_msgs/msg/Clock"]], kinds
        seen = list(times)
        assert seen == sorted(seen), "time goes on"
        steps = [b - a for a, b in zip(seen, seen[1:])]
        assert all(abs(step * 60 - round(step * 60)) < 1e-6 for step in steps), steps
        parameters = Parameters(client)
        assert parameters.set(publish_rate_hz=10.0, rate=1).results[0].successful
        count = len(times)
        wait_until(lambda: len(times) > count + 10, "ten more times")
        assert abs(times[-1] - times[-2] - 0.1) < 1e-6, times[-3:]


def check_standing(client):
    """A simulation that is paused goes on telling its time: recorders wait for it."""
    times = times_of(client)
    with Carom("break_shot"):
        assert Simulation(client).set_state(PAUSED) == OK
        count = len(times)
        wait_until(lambda: len(times) > count + 10, "the time, told again")
        assert len(set(times[-8:])) == 1, times[-8:]


def check_resolver(client):
    """With use_sim_time circles grow stale by /clock: they stay while it stands still."""
    publisher = client.node.create_publisher(Clock, "/clock", QOS)

    def tell(time_s):
        message = Clock()
        message.clock.sec, message.clock.nanosec = int(time_s), int(time_s % 1 * 1e9)
        publisher.publish(message)

    left, right = Circle(1, 0, 0, 1, 0, 1, 1), Circle(2, 2, 0, -1, 0, 1, 1)
    arguments = ["-p", "use_sim_time:=true", "-p", "stale_after_s:=0.2"]
    with Carom("resolver", "--ros-args", *arguments):
        client.connect()
        wait_until(lambda: publisher.get_subscription_count() > 0, "the node hears /clock")
        for _ in range(5):
            tell(100.0)
        client.ask(client.probe())
        client.publish([left])
        # Far longer than stale_after_s, by the wall clock.
        time.sleep(0.5)
        answer = client.ask([right], "the other one is not stale while time stands still")
        assert set(answer.velocities) == {1, 2}, answer.velocities
        tell(100.5)
        client.ask(client.probe())
        client.expect_no_answer([right], "time has passed: the other one is stale")
        client.publish([left])
        tell(50.0)
        client.ask(client.probe())
        client.expect_no_answer([right], "time has jumped back: nothing is known")


def main():
    with Client() as client:
        check_arena(client)
        check_standing(client)
        check_resolver(client)


if __name__ == "__main__":
    main()
