"""Bags that carom writes, judged by `rosbags`, by `mcap-ros2-support` and by rosidl's own hashes.

The node records itself while `carom record` records it from outside; both must hold what an rclpy
subscriber heard, byte by byte. Then the run is repeated from the bag and must agree bit by bit.
"""

import json
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from carom.msg import ErrorReport
from geometry_msgs.msg import PoseStamped, Twist
from harness import BINARY, Carom, Circle, Client, Heard, wait_until
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.interfaces import QosDurability, QosReliability
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import (
    LoadWorld, ResetSimulation, SetSimulationState, SpawnEntity,
)
from std_msgs.msg import String

# Where the interfaces of this environment say what their types are.
SHARE = Path(sys.prefix, "share")


def rosidl_hash(kind):
    """The hash that rosidl wrote beside the interface."""
    package, _, name = kind.split("/")
    said = json.loads((SHARE / package / "msg" / f"{name}.json").read_text())
    return next(each["hash_string"] for each in said["type_hashes"] if each["type_name"] == kind)


def check(path, compressed=False):
    """The bag as rosbags and mcap read it; the bytes by topic, in their order."""
    found = {}
    with Reader(path) as reader:
        store, types = get_typestore(Stores.EMPTY), {}
        for connection in reader.connections:
            types.update(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        store.register(types)
        for connection in reader.connections:
            kind = connection.msgtype
            assert connection.digest == rosidl_hash(kind), f"{kind}: {connection.digest}"
            assert connection.digest == store.hash_rihs01(kind), f"{kind}: its definition"
            assert len(connection.ext.offered_qos_profiles) == 1, f"{connection.topic}"
            found[connection.topic] = []
        stamps = []
        for connection, stamp, data in reader.messages():
            store.deserialize_cdr(data, connection.msgtype)
            found[connection.topic].append(bytes(data))
            stamps.append(stamp)
        counts = {c.topic: c.msgcount for c in reader.connections}
        assert counts == {topic: len(data) for topic, data in found.items()}, f"{counts}"
        assert reader.message_count == len(stamps)
        assert (reader.start_time, reader.end_time) == (stamps[0], stamps[-1] + 1)
        assert stamps == sorted(stamps), "messages are not in the order of time"
        qos = {c.topic: c.ext.offered_qos_profiles[0] for c in reader.connections}
    decoded = Counter()
    for file in path.glob("*.mcap"):
        with file.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()], validate_crcs=True)
            assert reader.get_header().profile == "ros2"
            packed = {index.compression for index in reader.get_summary().chunk_indexes}
            assert packed == ({"zstd"} if compressed else {""}), f"{packed}"
            decoded.update(channel.topic for _, channel, *_ in reader.iter_decoded_messages())
    assert decoded == Counter({topic: len(data) for topic, data in found.items() if data})
    return found, qos


def verify(path):
    run = subprocess.run([BINARY, "run", "--verify", "--from", path], capture_output=True,
                         text=True)
    assert run.returncode == 0 and "every bit agrees" in run.stdout, run.stdout + run.stderr
    return run.stdout.strip()


def call(client, kind, service, **fields):
    caller = client.node.create_client(kind, service)
    assert caller.wait_for_service(15.0), service
    future = caller.call_async(kind.Request(**fields))
    wait_until(future.done, f"an answer of {service}")
    return future.result()


def disturb(client):
    """Everything that changes a run: commands, observed circles, services, parameters."""
    drive = client.node.create_publisher(Twist, "pucks/ball/cmd_vel", 10)
    states = client.inboxes["arena_states"].messages
    twist = Twist()
    twist.linear.x, twist.linear.y = 1 / 3, -0.7
    before = len(states)
    wait_until(lambda: len(states) > before + 30, "states", each=lambda: drive.publish(twist))
    for k in range(20):
        client.publish([Circle(1, 40.0, 40.0, 1.0, 0.1, 0.5, 1.0),
                        Circle(2, 40.75 + 1e-3 * k, 40.0, -1.0, 1 / 3, 0.5, float("inf"))])
    value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=0.75)
    parameter = Parameter(name="command_timeout_s", value=value)
    answer = call(client, SetParameters, "carom/set_parameters", parameters=[parameter])
    assert answer.results[0].successful, answer
    pose = PoseStamped()
    pose.pose.position.x, pose.pose.position.y, pose.pose.orientation.w = 1.3, 1.3, 1.0
    spawned = call(client, SpawnEntity, "spawn_entity", name="newcomer", initial_pose=pose,
                   resource_string="{radius: 0.05, mass: 0.2}")
    assert spawned.result.result == 1, spawned
    before = len(states)
    wait_until(lambda: len(states) > before + 30, "states after the newcomer")
    reset = call(client, ResetSimulation, "reset_simulation", scope=0)
    assert reset.result.result == 1, reset
    # What was set holds after the reset, so this command is over soon.
    drive.publish(twist)
    before = len(states)
    wait_until(lambda: len(states) > before + 90, "states after the reset")
    scene = "restitution: 0.5\nwalls: {x: [0, 2], y: [0, 2]}\n"
    loaded = call(client, LoadWorld, "load_world", resource_string=scene)
    assert loaded.result.result == 1, loaded
    playing = SimulationState(state=SimulationState.STATE_PLAYING)
    played = call(client, SetSimulationState, "set_simulation_state", state=playing)
    assert played.result.result == 1, played
    spawned = call(client, SpawnEntity, "spawn_entity", name="first", initial_pose=pose,
                   resource_string="{radius: 0.05, velocity: [9.0, 5.0]}")
    assert spawned.result.result == 1, spawned
    before = len(states)
    wait_until(lambda: len(states) > before + 60, "states in the scene that was loaded")


def main():
    with tempfile.TemporaryDirectory() as name:
        own, other = Path(name, "own"), Path(name, "other")
        with Client(topics=["arena_states", "contacts", "corrected_velocities"]) as client:
            kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            latched = client.node.create_publisher(String, "latched", kept)
            latched.publish(String(data="said before anybody listened"))
            recorder = subprocess.Popen(
                [BINARY, "record", "/arena_states", "contacts", "latched", "/nobody", "-o", other,
                 "--compression", "zstd"], stdout=subprocess.PIPE, text=True)
            try:
                with Carom("teams", "--record", own) as carom:
                    states = client.inboxes["arena_states"].messages
                    wait_until(lambda: len(states) > 10, "states")
                    disturb(client)
                    # One is made each second, and the reset began it anew.
                    reports = Heard(client, ErrorReport, "error_report")
                    wait_until(lambda: reports, "a report")
                    carom.stop()
                    carom.wait_for_line("recorded .* 0 dropped")
            finally:
                recorder.send_signal(signal.SIGINT)
                line, _ = recorder.communicate(timeout=15)
            assert recorder.returncode == 0 and ", 0 dropped, 0 lost" in line, line
            stamps = [(m.header.stamp.sec, m.header.stamp.nanosec) for m in states]
        mine, qos = check(own)
        theirs, their_qos = check(other, compressed=True)
        assert all(each.reliability == QosReliability.RELIABLE for each in qos.values())
        assert their_qos["/latched"].durability == QosDurability.TRANSIENT_LOCAL
        assert their_qos["/arena_states"].durability == QosDurability.VOLATILE
        assert len(theirs["/latched"]) == 1, f"{theirs['/latched']}"
        for topic in ("/arena_states", "/contacts"):
            # What was heard from outside begins later; from there on it is the same.
            heard = theirs[topic]
            assert heard and mine[topic][-len(heard):] == heard, f"{topic}: other bytes"
        recorded = len(mine["/arena_states"])
        assert len(stamps) <= recorded, f"{len(stamps)} heard, {recorded} recorded"
        for topic in ("/circle_states", "/pucks/ball/cmd_vel", "/corrected_velocities", "/clock",
                      "/error_report", "/carom/journal", "/pucks/ball/odom", "/parameter_events"):
            assert mine[topic], f"nothing of {topic}"
        print(verify(own))
        print(f"own {sum(map(len, mine.values()))} messages, {line.strip()}")


if __name__ == "__main__":
    main()
