"""simulation_interfaces: pause, step, reset, look, spawn, place, delete, load, with their codes."""

import time

from action_msgs.msg import GoalStatus
from carom.msg import CircleStates
from geometry_msgs.msg import PoseStamped, Twist, Vector3
from harness import CHANGED, QOS, TIMEOUT_S, Carom, Client, Heard, wait_until
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.msg import (
    Bounds, EntityCategory, EntityFilters, Result, SimulationState, SpawnEntity, TagsFilter,
)
from simulation_interfaces import srv

OK, NOT_FOUND = Result.RESULT_OK, Result.RESULT_NOT_FOUND
FAILED, WRONG_STATE = Result.RESULT_OPERATION_FAILED, Result.RESULT_INCORRECT_STATE
STOPPED, PLAYING, PAUSED = (SimulationState.STATE_STOPPED, SimulationState.STATE_PLAYING,
                            SimulationState.STATE_PAUSED)


def notify(*_):
    with CHANGED:
        CHANGED.notify_all()


class Simulation:
    """All services of a simulator, called one by one."""

    def __init__(self, client, namespace=""):
        self.node, self.namespace, self.clients = client.node, namespace, {}

    def call(self, kind, **fields):
        if kind not in self.clients:
            name = "".join("_" + c.lower() if c.isupper() else c for c in kind).strip("_")
            service = self.node.create_client(getattr(srv, kind), f"{self.namespace}/{name}")
            assert service.wait_for_service(TIMEOUT_S), f"{name} is not there"
            # As of the action below.
            time.sleep(0.25)
            self.clients[kind] = service
        future = self.clients[kind].call_async(getattr(srv, kind).Request(**fields))
        future.add_done_callback(notify)
        wait_until(future.done, f"{kind} answers")
        return future.result()

    def verdict(self, kind, **fields):
        result = self.call(kind, **fields).result
        assert (result.result == OK) == (not result.error_message), result
        return result.result

    def set_state(self, state):
        return self.verdict("SetSimulationState", state=SimulationState(state=state))

    def state(self):
        return self.call("GetSimulationState").state.state

    def entities(self, **filters):
        response = self.call("GetEntities", filters=EntityFilters(**filters))
        assert response.result.result == OK, response
        return list(response.entities)

    def entity(self, name):
        response = self.call("GetEntityState", entity=name)
        assert response.result.result == OK, response
        return response.state

    def time(self):
        stamp = self.entity("left").header.stamp
        return stamp.sec + 1e-9 * stamp.nanosec


def pose_at(x, y):
    pose = PoseStamped()
    pose.pose.position.x, pose.pose.position.y = float(x), float(y)
    return pose


def check_time(simulation, client):
    assert simulation.state() == PLAYING
    assert simulation.verdict("StepSimulation", steps=1) == FAILED, "not paused"
    assert simulation.set_state(PAUSED) == OK
    assert simulation.set_state(PAUSED) == 101, "already paused"
    before = simulation.time()
    assert simulation.time() == before, "time stands still"
    assert simulation.verdict("StepSimulation", steps=6) == OK
    after = simulation.time()
    # A step ends at a tick; the first of them may be shorter.
    assert 5 / 60 - 1e-6 < after - before < 6 / 60 + 1e-6, (before, after)
    check_action(simulation, client, after)
    assert simulation.set_state(PLAYING) == OK
    wait_until(lambda: simulation.time() > after + 0.2, "time passes again")
    assert simulation.set_state(SimulationState.STATE_LOADING_WORLD) == 103


def check_action(simulation, client, before):
    steps = ActionClient(client.node, SimulateSteps, "simulate_steps")
    assert steps.wait_for_server(TIMEOUT_S), "the action is not there"
    # A match has two ends, and rclpy tells of one: the server must know whom to answer.
    time.sleep(1.0)
    feedback = []

    def result_of(count, cancel=False):
        sent = steps.send_goal_async(SimulateSteps.Goal(steps=count), feedback_callback=(
            lambda message: feedback.append(message.feedback)))
        sent.add_done_callback(notify)
        wait_until(sent.done, "the goal is answered")
        handle = sent.result()
        assert handle.accepted, "the goal is not accepted"
        if cancel:
            handle.cancel_goal_async().add_done_callback(notify)
        result = handle.get_result_async()
        result.add_done_callback(notify)
        wait_until(result.done, "the result comes")
        return result.result().status, result.result().result.result.result

    assert result_of(12) == (GoalStatus.STATUS_SUCCEEDED, OK)
    assert abs(simulation.time() - before - 12 / 60) < 1e-6
    # Long enough that the client is ready for feedback before the end.
    count = 20_000
    assert result_of(count) == (GoalStatus.STATUS_SUCCEEDED, OK)
    long = [f for f in feedback if f.completed_steps + f.remaining_steps == count]
    assert len(long) > 10, len(feedback)
    completed = [f.completed_steps for f in long]
    assert completed == sorted(completed), "steps are counted up"
    status, code = result_of(10_000_000, cancel=True)
    assert (status, code) == (GoalStatus.STATUS_CANCELED, FAILED), (status, code)
    stands = simulation.time()
    assert simulation.time() == stands, "cancelled: time stands still"


def check_entities(simulation):
    assert simulation.entities() == ["left", "right"]
    assert simulation.entities(filter="^l") == ["left"]
    robots = [EntityCategory(category=EntityCategory.CATEGORY_ROBOT)]
    assert simulation.entities(categories=robots) == ["left", "right"]
    assert simulation.entities(tags=TagsFilter(tags=["spawned"])) == []
    sphere = Bounds(type=Bounds.TYPE_SPHERE, points=[Vector3(x=-99.0), Vector3(x=1.0)])
    assert simulation.entities(bounds=sphere) == []
    broken = simulation.call("GetEntities", filters=EntityFilters(filter="("))
    assert broken.result.result == FAILED and "filter" in broken.result.error_message
    tags = TagsFilter(tags=["spawned"], filter_mode=9)
    broken = simulation.call("GetEntities", filters=EntityFilters(tags=tags))
    assert broken.result.result == FAILED and "filter_mode 9" in broken.result.error_message
    info = simulation.call("GetEntityInfo", entity="left").info
    assert info.category.category == EntityCategory.CATEGORY_ROBOT and "driven" in info.tags, info
    bounds = simulation.call("GetEntityBounds", entity="left").bounds
    assert bounds.type == Bounds.TYPE_SPHERE and bounds.points[1].x > 0, bounds
    for kind in ("GetEntityState", "GetEntityInfo", "GetEntityBounds", "DeleteEntity"):
        assert simulation.verdict(kind, entity="nobody") == NOT_FOUND, kind
    states = simulation.call("GetEntitiesStates", filters=EntityFilters())
    assert list(states.entities) == ["left", "right"] and len(states.states) == 2, states


def spawn(simulation, name, at, text="{radius: 0.05, mass: 2}", **fields):
    return simulation.call("SpawnEntity", name=name, resource_string=text,
                           initial_pose=pose_at(*at), **fields)


def check_spawning(simulation, client):
    # Where everything is known to be: left and right lie along y = 0.5.
    assert simulation.set_state(STOPPED) == OK
    left = simulation.entity("left").pose.position
    new = spawn(simulation, "new", (0.2, 0.15))
    assert (new.result.result, new.entity_name) == (OK, "new"), new
    position = simulation.entity("new").pose.position
    assert (position.x, position.y) == (0.2, 0.15)
    refused = [
        (101, spawn(simulation, "new", (0.6, 0.15))), (102, spawn(simulation, "a b", (0.6, 0.15))),
        (104, spawn(simulation, "b", (0.6, 0.15), "")),
        (106, spawn(simulation, "b", (0.6, 0.15), "{mass: 1}")),
        (106, spawn(simulation, "b", (0.6, 0.15), "{radius: -1}")),
        (103, spawn(simulation, "b", (0.6, 0.15), uri="package://x")),
        (105, spawn(simulation, "b", (0.6, 0.15), entity_namespace="a b")),
        (109, spawn(simulation, "b", (left.x, left.y))), (109, spawn(simulation, "b", (99, 0))),
    ]
    for code, response in refused:
        assert response.result.result == code, (code, response)
    again = spawn(simulation, "new", (0.6, 0.15), allow_renaming=True)
    assert again.result.result == OK and again.entity_name not in ("", "new"), again
    requests = [SpawnEntity(name=f"many_{k}", initial_pose=pose_at(0.1 + 0.2 * k, 0.85))
                for k in range(3)]
    for request in requests[:2]:
        request.entity_resource.resource_string = "{radius: 0.05, driven: false}"
    many = simulation.call("SpawnEntities", spawn_requests=requests)
    assert many.result.result == 150 and len(many.results) == 3, many
    assert [r.result.result for r in many.results] == [OK, OK, 104], many
    # The results of so many do not fit into an answer: which failed is told in words.
    crowd = [SpawnEntity(name="left", initial_pose=pose_at(0.6, 0.15)) for _ in range(100)]
    lost = simulation.call("SpawnEntities", spawn_requests=crowd)
    assert lost.result.result == 150 and not lost.results, lost
    assert "100 of 100 failed; number 0: " in lost.result.error_message, lost
    assert simulation.entities(tags=TagsFilter(tags=["spawned"])) == [
        "new", again.entity_name, "many_0", "many_1"]
    assert simulation.verdict("DeleteEntity", entity=again.entity_name) == OK
    check_placing(simulation)
    check_driving(simulation, client)
    assert simulation.verdict("ResetSimulation", scope=4) == OK, "spawned alone"
    assert simulation.entities() == ["left", "right"]


def check_placing(simulation):
    state = simulation.entity("new")
    state.pose.position.y, state.twist.linear.x = 0.45, 0.5
    assert simulation.verdict("SetEntityState", entity="new", state=state) == OK
    now = simulation.entity("new")
    assert (now.pose.position.y, now.twist.linear.x) == (0.45, 0.5), now
    state.pose.position.x = 99.0
    assert simulation.verdict("SetEntityState", entity="new", state=state) == 101, "outside"
    state.pose.position.x = float("nan")
    assert simulation.verdict("SetEntityState", entity="new", state=state) == 101, "nowhere"
    state = simulation.entity("new")
    state.header.frame_id = "elsewhere"
    assert simulation.verdict("SetEntityState", entity="new", state=state) == 101, "frame"
    assert simulation.entity("new").pose.position.y == 0.45, "a refusal changes nothing"


def check_driving(simulation, client):
    """A puck that was spawned has its topics, in the namespace that was asked for."""
    assert spawn(simulation, "robot", (1.1, 0.15), entity_namespace="fleet",
                 text="{radius: 0.05, drive: {model: holonomic}}").result.result == OK
    odometry = Heard(client, Odometry, "/fleet/pucks/robot/odom")
    command = client.node.create_publisher(Twist, "/fleet/pucks/robot/cmd_vel", QOS)
    wait_until(lambda: command.get_subscription_count() > 0, "the robot's cmd_vel")
    twist = Twist()
    twist.linear.x = 0.125
    assert simulation.set_state(PLAYING) == OK
    wait_until(lambda: any(abs(o.twist.twist.linear.x - 0.125) < 1e-12 for o in odometry),
               "the robot goes as it was told", each=lambda: command.publish(twist))
    assert odometry[-1].child_frame_id == "robot/base_link"
    assert simulation.verdict("DeleteEntity", entity="robot") == OK
    assert simulation.verdict("GetEntityState", entity="robot") == NOT_FOUND


def check_reset(simulation):
    assert simulation.set_state(PLAYING) in (OK, 101)
    wait_until(lambda: simulation.time() > 0.5, "some time")
    assert simulation.set_state(PAUSED) == OK
    moved = simulation.entity("left").pose.position.x
    assert simulation.verdict("ResetSimulation", scope=1) == OK, "time alone"
    assert simulation.time() == 0.0 and simulation.entity("left").pose.position.x == moved
    assert simulation.verdict("StepSimulation", steps=2) == OK
    later = simulation.time()
    assert simulation.verdict("ResetSimulation", scope=2) == OK, "state alone"
    start = simulation.entity("left").pose.position.x
    assert simulation.time() == later and start != moved
    assert simulation.verdict("ResetSimulation", scope=8) == FAILED, "no such scope"
    assert simulation.time() == later, "a refusal changes nothing"
    assert simulation.verdict("DeleteEntity", entity="right") == OK
    assert simulation.set_state(STOPPED) == OK
    assert simulation.entities() == ["left", "right"], "what was deleted is back"
    assert (simulation.time(), simulation.entity("left").pose.position.x) == (0.0, start)
    assert simulation.set_state(PAUSED) == OK, "from stopped, without a tick"
    assert simulation.time() == 0.0


def check_worlds(simulation, client):
    names = [world.name for world in simulation.call("GetAvailableWorlds").worlds]
    assert {"arena", "thousand", "resolver"} <= set(names), names
    world = simulation.call("LoadWorld", uri="newtons_cradle")
    assert world.result.result == OK, world
    assert simulation.state() == STOPPED, "a world that was loaded is stopped"
    assert "cradle" in simulation.call("GetCurrentWorld").world.name.lower()
    assert "left" not in simulation.entities()
    assert simulation.verdict("LoadWorld") == 102
    assert simulation.verdict("LoadWorld", uri="http://x/y.sdf") == 101
    assert simulation.verdict("LoadWorld", resource_string="walls: 1") == 103
    assert "left" not in simulation.entities(), "a refusal changes nothing"
    assert simulation.verdict("UnloadWorld") == OK
    assert simulation.verdict("UnloadWorld") == 101
    assert simulation.verdict("GetCurrentWorld") == 101
    assert simulation.state() == SimulationState.STATE_NO_WORLD
    assert simulation.set_state(PLAYING) == WRONG_STATE
    assert simulation.entities() == []
    scene = ("walls: {x: [0, 1], y: [0, 1]}\nnode: {command_timeout_s: 0.5}\n"
             "pucks: [{name: left, position: [0.5, 0.5], radius: 0.1}]")
    assert simulation.verdict("LoadWorld", resource_string=scene) == OK
    assert simulation.set_state(PLAYING) == OK
    wait_until(lambda: simulation.time() > 0.1, "the new world moves")
    states = []
    client.node.create_subscription(CircleStates, "arena_states", states.append, QOS)
    wait_until(lambda: states and len(states[-1].circles) == 1, "states of the new world")


def check_topics(simulation, client):
    """Topics follow the names of the new world, whose pucks have the ids of the old one's."""
    puck = "{{name: {}, position: [0.{}, 0.5], radius: 0.1}}"
    for first, second in (("one", "two"), ("two", "one")):
        pucks = ", ".join(puck.format(*each) for each in ((first, 2), (second, 8)))
        assert simulation.verdict(
            "LoadWorld", resource_string="pucks: [" + pucks + "]") == OK
        assert simulation.set_state(PLAYING) == OK
        odometry = Heard(client, Odometry, "/pucks/one/odom")
        command = client.node.create_publisher(Twist, "/pucks/one/cmd_vel", QOS)
        wait_until(lambda: command.get_subscription_count() > 0, "cmd_vel of `one`")
        twist = Twist()
        twist.linear.y = 0.125
        wait_until(lambda: odometry and odometry[-1].twist.twist.linear.y == 0.125,
                   "`one` goes as it was told", each=lambda: command.publish(twist))
        assert odometry[-1].child_frame_id == "one/base_link", odometry[-1].child_frame_id
        assert simulation.entity("two").twist.linear.y == 0.0
        client.node.destroy_publisher(command)


def main():
    scene_name = "head_on"
    with Client() as client, Carom(scene_name) as carom:
        simulation = Simulation(client)
        features = simulation.call("GetSimulatorFeatures").features
        assert {0, 10, 20, 26, 31, 33, 40} <= set(features.features), features
        assert features.spawn_formats == ["yaml"], features
        check_time(simulation, client)
        check_entities(simulation)
        check_spawning(simulation, client)
        check_reset(simulation)
        check_worlds(simulation, client)
        check_topics(simulation, client)
        assert carom.wait_for_line("WARN", "load_world", "command_timeout_s"), carom.lines
        assert simulation.set_state(SimulationState.STATE_QUITTING) == OK
        wait_until(lambda: not carom.alive(), "the node quits")
        assert carom.process.returncode == 0


if __name__ == "__main__":
    main()
