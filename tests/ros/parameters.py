"""Every setting is a parameter: from files and the command line, and while the node runs."""

import time

from carom.msg import CircleStates
from harness import CHANGED, TIMEOUT_S, Carom, Circle, Client, Heard, scene, wait_until
from rcl_interfaces.msg import ParameterEvent, ParameterType
from rcl_interfaces.srv import (
    DescribeParameters, GetParameters, GetParameterTypes, ListParameters, SetParameters,
    SetParametersAtomically,
)
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import qos_profile_parameter_events
from refused import check_refused
from simulation_interfaces.srv import ResetSimulation

SERVICES = {
    "describe_parameters": DescribeParameters, "get_parameters": GetParameters,
    "get_parameter_types": GetParameterTypes, "list_parameters": ListParameters,
    "set_parameters": SetParameters, "set_parameters_atomically": SetParametersAtomically,
}
FILE = """
/**:
  ros__parameters:
    stale_after_s: 2.0
    frame_id: everywhere
/arena/carom:
  ros__parameters:
    frame_id: table
    publish_rate_hz: 30
other:
  ros__parameters:
    frame_id: wrong
"""

ONE_PUCK = """
walls: {x: [0, 8], y: [0, 4]}
pucks:
  - {name: one, position: [7, 2], velocity: [0, 1], radius: 0.5}
"""


class Parameters:
    """The six services of a node, called one by one."""

    def __init__(self, client, node="/carom"):
        self.node = client.node
        self.clients = {name: self.node.create_client(kind, f"{node}/{name}")
                        for name, kind in SERVICES.items()}
        for name, service in self.clients.items():
            assert service.wait_for_service(TIMEOUT_S), f"{node}/{name} is not there"

    def call(self, service, **fields):
        request = SERVICES[service].Request(**fields)
        future = self.clients[service].call_async(request)
        with CHANGED:
            future.add_done_callback(lambda _: self._notify())
        wait_until(future.done, f"{service} answers")
        return future.result()

    @staticmethod
    def _notify():
        with CHANGED:
            CHANGED.notify_all()

    def get(self, *names):
        values = self.call("get_parameters", names=list(names)).values
        return [parameter_value_to_python(value) for value in values]

    def set(self, service="set_parameters", **values):
        parameters = [Parameter(name, value=value).to_parameter_msg()
                      for name, value in values.items()]
        return self.call(service, parameters=parameters)


def check_services(client):
    events = Heard(client, ParameterEvent, "/parameter_events", qos_profile_parameter_events)
    with Carom("resolver") as carom:
        parameters = Parameters(client)
        names = parameters.call("list_parameters").result.names
        assert {"scene", "rate", "publish_rate_hz", "stale_after_s", "contact_margin_m",
                "frame_id", "circle_topics", "use_sim_time", "method"} <= set(names), names
        assert names == sorted(names), names
        # One by one, as `ros2 param describe` asks: all at once would not fit into a datagram.
        for name in names:
            descriptor, = parameters.call("describe_parameters", names=[name]).descriptors
            assert descriptor.description, descriptor
            assert descriptor.type != ParameterType.PARAMETER_NOT_SET, descriptor
        assert not parameters.call("describe_parameters", names=names).descriptors
        carom.wait_for_line("parameters: an answer of", "larger than one datagram")
        rate = parameters.call("describe_parameters", names=["publish_rate_hz"]).descriptors[0]
        assert not rate.read_only and rate.floating_point_range[0].to_value == 1e5, rate
        types = parameters.call("get_parameter_types", names=["scene", "rate", "nothing"]).types
        assert list(types) == [4, 3, 0], types
        assert parameters.get("scene", "circle_topics", "nothing") == [
            "resolver", ["circle_states"], None]
        check_sets(parameters)
        mine = [event for event in events if event.node == "/carom"]
        wait_until(lambda: [e for e in events if e.changed_parameters], "an event of a change")
        changed = [p.name for e in events for p in e.changed_parameters]
        assert set(changed) <= {"stale_after_s", "contact_margin_m"}, (changed, mine)


def check_sets(parameters):
    result, = parameters.set(stale_after_s=0.25).results
    assert result.successful, result.reason
    refused = {
        "scene": ("teams", "read-only"), "stale_after_s": (-1.0, "not in"),
        "frame_id": ("odom", "read-only"), "rate": ("fast", "type"), "nothing": (1, "not declared"),
        "contact_margin_m": (float("nan"), "not in"),
    }
    for name, (value, reason) in refused.items():
        result, = parameters.set(**{name: value}).results
        assert not result.successful and reason in result.reason, (name, result)
    both = parameters.set("set_parameters_atomically", stale_after_s=9.0, scene="teams").result
    assert not both.successful and "scene" in both.reason, both
    assert parameters.get("stale_after_s", "scene") == [0.25, "resolver"]
    both = parameters.set("set_parameters_atomically", stale_after_s=3, contact_margin_m=0.5).result
    assert both.successful, both.reason
    assert parameters.get("stale_after_s", "contact_margin_m") == [3.0, 0.5]


def check_effect(client):
    """A margin set while the node runs is in force for the next message."""
    apart = [Circle(1, 0, 0, 1, 0, 1, 1), Circle(2, 2.25, 0, -1, 0, 1, 1)]
    with Carom("resolver"):
        client.connect()
        parameters = Parameters(client)
        client.expect_no_answer(apart, "circles apart")
        assert parameters.set(contact_margin_m=0.5).results[0].successful
        answer = client.ask(apart, "circles within the margin")
        assert answer.velocities == {1: (-1.0, 0.0), 2: (1.0, 0.0)}, answer.velocities


def check_files(client):
    path = scene(FILE, "parameters.yaml")
    arguments = ["--ros-args", "-r", "__ns:=/arena", "--params-file", str(path),
                 "-p", "scene:=break_shot", "-p", "rate:=0.5"]
    with Carom(*arguments):
        parameters = Parameters(client, "/arena/carom")
        names = ["frame_id", "stale_after_s", "publish_rate_hz", "scene", "rate"]
        assert parameters.get(*names) == ["table", 2.0, 30.0, "break_shot", 0.5]
        result, = parameters.set(use_sim_time=True).results
        assert not result.successful and "/clock" in result.reason, result
        assert parameters.set(rate=2).results[0].successful


def check_walls(client):
    """Walls move while it runs and bring pucks inside; a reset has them where the scene has."""
    states = Heard(client, CircleStates, "arena_states", of=lambda message: message.circles)
    events = Heard(client, ParameterEvent, "/parameter_events", qos_profile_parameter_events)

    def lies_within(left, right):
        """Of the latest state: the puck's circle."""
        return states and left <= states[-1][0].x - 0.5 and states[-1][0].x + 0.5 <= right

    with Carom(scene(ONE_PUCK)):
        parameters = Parameters(client)
        reset = client.node.create_client(ResetSimulation, "/reset_simulation")
        assert reset.wait_for_service(TIMEOUT_S)
        assert parameters.get("walls") == [[0.0, 8.0, 0.0, 4.0]]
        wait_until(lambda: lies_within(6.0, 8.0), "the puck where the scene has it")
        for sides, reason in [([0.0, 4.0], "four numbers"), ([0.0, 0.5, 0.0, 4.0], "room"),
                              ([4.0, 0.0, 0.0, 4.0], "room"),
                              ([0.0, float("nan"), 0.0, 4.0], "room")]:
            result, = parameters.set(walls=sides).results
            assert not result.successful and reason in result.reason, (sides, result)
        assert lies_within(6.0, 8.0), states[-1]
        assert parameters.set(walls=[0.0, 3.0, 0.0, 4.0]).results[0].successful
        wait_until(lambda: lies_within(0.0, 3.0), "the puck brought inside")
        events.clear()
        reset.call_async(ResetSimulation.Request())
        wait_until(lambda: lies_within(6.0, 8.0), "the puck back where the scene has it")
        wait_until(lambda: [e for e in events if e.changed_parameters], "an event of the reset")
        assert parameters.get("walls") == [[0.0, 8.0, 0.0, 4.0]]
    with Carom(scene(ONE_PUCK), "--ros-args", "-p", "walls:=[0.0, 9.0, -1.0, 4.0]"):
        assert Parameters(client).get("walls") == [[0.0, 9.0, -1.0, 4.0]]


def check_first_calls():
    """Whoever calls in the moment in which it finds a service is answered at once."""
    took = []
    with Carom("resolver"):
        for number in range(8):
            with Client(topics=[]) as client:
                caller = client.node.create_client(ListParameters, "/carom/list_parameters")
                while not caller.service_is_ready():
                    time.sleep(0.0005)
                begin = time.monotonic()
                answer = caller.call_async(ListParameters.Request())
                wait_until(answer.done, f"an answer to first call {number}")
                took.append(time.monotonic() - begin)
    # What DDS had lost came after 3 s, half of all; a busy machine may hold up one.
    assert sorted(took)[-2] < 1.0, f"first calls: {took}"


def main():
    check_first_calls()
    with Client() as client:
        check_walls(client)
        check_services(client)
        check_effect(client)
        check_files(client)
    check_refused(["--ros-args", "-p", "rate:=fast"], "rate", "double")
    check_refused(["--ros-args", "-p", "publish_rate_hz:=-1"], "publish_rate_hz", "not in")
    check_refused(["--ros-args", "-p", "method:=magic"], "method", "events, plain")
    check_refused(["--ros-args", "-p", "step_s:=0.0"], "step_s", "above 0")
    check_refused(["break_shot", "--ros-args", "-p", "walls:=[0.0, 0.1, 0.0, 0.1]"], "walls", "in")
    check_refused(["--ros-args", "-r", "__ns:=a b"], "a b", "not a ROS name")
    check_refused(["--ros-args", "--frob"], "unknown argument", "--frob")
    check_refused(["--ros-args", "--params-file", "nowhere.yaml"], "nowhere.yaml", "No such file")


if __name__ == "__main__":
    main()
