"""`carom replay`: a bag that others wrote, heard by rclpy as it was recorded.

Content and order to the byte, types and profiles from the graph, time within what a machine with
other work keeps: the recorded 3 s at twice their pace.
"""

import subprocess
import tempfile
import time
from pathlib import Path

from builtin_interfaces.msg import Time as Stamp
from carom.msg import CircleState, CircleStates
from geometry_msgs.msg import Twist
from harness import BINARY, QOS, ROOT, Client, Heard, nanoseconds, wait_until
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosbags.interfaces import (Qos, QosDurability, QosHistory, QosLiveliness, QosReliability,
                                QosTime)
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

START_NS = 1_700_000_000_000_000_000
PERIOD_NS, COUNT = 20_000_000, 150
# Enough for Fast DDS to lose it whole.
MANY = 5_000


# Many more than the buffer of a socket holds.
HURRIED = 4_000


def qos(reliable, kept, depth=5):
    for_ever = QosTime(9223372036, 854775807)
    return Qos(QosHistory.KEEP_LAST, depth,
               QosReliability.RELIABLE if reliable else QosReliability.BEST_EFFORT,
               QosDurability.TRANSIENT_LOCAL if kept else QosDurability.VOLATILE,
               for_ever, for_ever, QosLiveliness.AUTOMATIC, for_ever, False)


def twist(k):
    message = Twist()
    message.linear.x, message.angular.z = k / 3.0, -float(k)
    return message


def write(path, storage):
    """A latched text, a twist every 20 ms, and one list that is too large for one message."""
    store, own = get_typestore(Stores.ROS2_KILTED), {}
    for message in ("CircleState", "CircleStates"):
        text = (ROOT / "msg" / f"{message}.msg").read_text()
        own.update(get_types_from_msg(text, f"carom/msg/{message}"))
    store.register(own)
    with Writer(path, version=9, storage_plugin=storage) as writer:
        def add(topic, kind, profile):
            return writer.add_connection(topic, kind, typestore=store,
                                         offered_qos_profiles=[profile])
        latched = add("/latched", "std_msgs/msg/String", qos(True, True))
        twists = add("/twists", "geometry_msgs/msg/Twist", qos(False, False))
        states = add("/states", "carom/msg/CircleStates", qos(True, False))
        writer.write(latched, START_NS, serialize_message(String(data="first")))
        for k in range(COUNT):
            writer.write(twists, START_NS + (k + 1) * PERIOD_NS, serialize_message(twist(k)))
        many = CircleStates()
        many.header.stamp = Stamp(sec=7)
        many.circles = [CircleState(id=k, x=k / 3.0, radius=1.0, mass=1.0) for k in range(MANY)]
        writer.write(states, START_NS + (COUNT + 1) * PERIOD_NS, serialize_message(many))
    return many


def offered(client, topic):
    infos = client.node.get_publishers_info_by_topic(topic)
    return [(info.topic_type, info.qos_profile.reliability, info.qos_profile.durability)
            for info in infos]


def play(client, path, *arguments):
    """Plays a bag; the line that it ends with, and the seconds that it took."""
    start = time.monotonic()
    run = subprocess.run([BINARY, "replay", path, *arguments], capture_output=True, text=True,
                         timeout=60)
    assert run.returncode == 0, run.stderr
    return run.stdout.strip(), time.monotonic() - start


def check_whole(client, path, many):
    kept = QoSProfile(depth=5, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    latched = Heard(client, String, "/latched", kept)
    sensor = QoSProfile(depth=1_000, reliability=ReliabilityPolicy.BEST_EFFORT)
    twists = Heard(client, Twist, "/twists", sensor, of=lambda m: (time.monotonic(), m))
    states = Heard(client, CircleStates, "/states", QOS)
    clock = Heard(client, Clock, "/clock", sensor, of=lambda m: nanoseconds(m.clock))
    process = subprocess.Popen([BINARY, "replay", path, "--rate", "2", "--clock", "50", "--delay",
                                "3"], stdout=subprocess.PIPE, text=True)
    for topic, expected in (
            ("/latched", ("std_msgs/msg/String", ReliabilityPolicy.RELIABLE,
                          DurabilityPolicy.TRANSIENT_LOCAL)),
            ("/twists", ("geometry_msgs/msg/Twist", ReliabilityPolicy.BEST_EFFORT,
                         DurabilityPolicy.VOLATILE)),
            ("/states", ("carom/msg/CircleStates", ReliabilityPolicy.RELIABLE,
                         DurabilityPolicy.VOLATILE))):
        wait_until(lambda: offered(client, topic) == [expected], f"{topic} as it was recorded")
    wait_until(lambda: states and len(states) == states[0].parts, "all parts of the large list",
               timeout_s=30.0)
    line, _ = process.communicate(timeout=15)
    assert line.startswith(f"{COUNT + 2} messages played, 0 could not be sent"), line
    assert [m.data for m in latched] == ["first"], f"{latched}"
    assert [m for _, m in twists] == [twist(k) for k in range(COUNT)], f"{len(twists)} twists"
    circles = [circle for part in sorted(states, key=lambda m: m.part) for circle in part.circles]
    assert circles == list(many.circles), f"{len(circles)} circles of {MANY}"
    took = twists[-1][0] - twists[0][0]
    expected = (COUNT - 1) * PERIOD_NS * 1e-9 / 2
    assert expected * 0.9 <= took <= expected + 3.0, f"{took} s, expected {expected} s"
    assert clock == sorted(clock) and len(clock) >= 60, f"{len(clock)} times"
    assert START_NS <= clock[0] and clock[-1] <= START_NS + (COUNT + 2) * PERIOD_NS
    return took


def check_part(client, path):
    latched = Heard(client, String, "/latched", QOS)
    twists = Heard(client, Twist, "/twists", QoSProfile(
        depth=1_000, reliability=ReliabilityPolicy.BEST_EFFORT))
    line, _ = play(client, path, "--topics", "twists", "--rate", "0", "--delay", "3")
    assert line.startswith(f"{COUNT} messages played"), line
    wait_until(lambda: len(twists) > 0, "twists")
    assert not latched, "a topic that was not asked for was played"
    run = subprocess.run([BINARY, "replay", path, "--topics", "nobody"], capture_output=True,
                         text=True)
    assert run.returncode == 2 and "no topic nobody in the bag; there are" in run.stderr, run


def check_hurry(client, path):
    """As fast as possible, to a subscriber that is reliable: nothing is lost."""
    store = get_typestore(Stores.ROS2_KILTED)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        texts = writer.add_connection("/texts", "std_msgs/msg/String", typestore=store,
                                      offered_qos_profiles=[qos(True, False, HURRIED)])
        for k in range(HURRIED):
            text = String(data=f"{k} {'x' * 300}")
            writer.write(texts, START_NS + k * 1_000_000, serialize_message(text))
    heard = Heard(client, String, "/texts", QoSProfile(depth=HURRIED))
    line, took = play(client, path, "--rate", "0", "--delay", "3")
    assert line.startswith(f"{HURRIED} messages played, 0 could not be sent"), line
    wait_until(lambda: len(heard) == HURRIED, f"all of {HURRIED} texts, not {len(heard)}")
    assert [int(m.data.split()[0]) for m in heard] == list(range(HURRIED))
    print(f"{HURRIED} texts, none lost, in {took - 3:.2f} s")


def main():
    with tempfile.TemporaryDirectory() as name:
        for storage in (StoragePlugin.MCAP, StoragePlugin.SQLITE3):
            path = Path(name, storage.name.lower())
            many = write(path, storage)
            with Client(topics=[]) as client:
                took = check_whole(client, path, many)
            print(f"{storage.name}: {COUNT} twists in {took:.2f} s at twice the pace of 3 s")
        with Client(topics=[]) as client:
            check_part(client, path)
        with Client(topics=[]) as client:
            check_hurry(client, Path(name, "hurried"))


if __name__ == "__main__":
    main()
