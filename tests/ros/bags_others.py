"""What carom publishes, recorded by a standard recorder: raw rclpy subscriptions and `rosbags`.

The recorder takes bytes, types and profiles from the graph alone, as `ros2 bag record` does. What it
wrote is read back by `rosbags`, by `mcap-ros2-support` and by carom, in both storages.
"""

import subprocess
import tempfile
import time
from collections import Counter, defaultdict
from importlib import import_module
from pathlib import Path

from carom.msg import CircleStates, CircleVelocities, Contacts
from geometry_msgs.msg import Twist
from harness import (BINARY, QOS, ROOT, Carom, Circle, Client, circle_states, nanoseconds,
                     next_stamp, wait_until)
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.interfaces import (Qos, QosDurability, QosHistory, QosLiveliness, QosReliability,
                                QosTime)
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

PUBLISHED = {"/arena_states", "/clock", "/contacts", "/corrected_velocities", "/diagnostics",
             "/error_report", "/markers", "/parameter_events"}
FOR_EVER = QosTime(9223372036, 854775807)


def types():
    """The standard types of Kilted, and carom's from its .msg files."""
    store = get_typestore(Stores.ROS2_KILTED)
    own = {}
    for path in sorted((ROOT / "msg").glob("*.msg")):
        own.update(get_types_from_msg(path.read_text(), f"carom/msg/{path.stem}"))
    store.register(own)
    return store


def profile(info):
    """The profile that a publisher offers, as rosbags names it."""
    qos = info.qos_profile
    reliable = qos.reliability == ReliabilityPolicy.RELIABLE
    kept = qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert qos.history in (HistoryPolicy.UNKNOWN, HistoryPolicy.KEEP_LAST), f"{qos}"
    assert qos.liveliness == LivelinessPolicy.AUTOMATIC, f"{qos}"
    return Qos(QosHistory.KEEP_LAST, qos.depth,
               QosReliability.RELIABLE if reliable else QosReliability.BEST_EFFORT,
               QosDurability.TRANSIENT_LOCAL if kept else QosDurability.VOLATILE,
               FOR_EVER, FOR_EVER, QosLiveliness.AUTOMATIC, FOR_EVER, False)


class Recorder:
    """Keeps the bytes of every topic that somebody publishes, with what the graph says of it."""

    def __init__(self, client):
        self.client = client
        self.kinds, self.qos = {}, {}
        self.messages = []

    def open(self):
        """Subscribes to what is new; whether all that carom publishes is there."""
        node = self.client.node
        for topic, kinds in node.get_topic_names_and_types():
            offers = [info for info in node.get_publishers_info_by_topic(topic)
                      if info.node_name == "carom"]
            if topic in self.kinds or not offers or "/msg/" not in kinds[0] or "_action" in topic:
                continue
            package, _, name = kinds[0].split("/")
            self.kinds[topic], self.qos[topic] = kinds[0], profile(offers[0])
            node.create_subscription(getattr(import_module(f"{package}.msg"), name), topic,
                                     lambda data, topic=topic: self.keep(topic, data), QOS,
                                     raw=True)
        return PUBLISHED <= set(self.kinds)

    def keep(self, topic, data):
        self.messages.append((topic, time.time_ns(), bytes(data)))

    def count(self):
        return Counter(topic for topic, *_ in self.messages)

    def write(self, path, storage, store):
        with Writer(path, version=9, storage_plugin=storage) as writer:
            connections = {
                topic: writer.add_connection(topic, kind, typestore=store,
                                             offered_qos_profiles=[self.qos[topic]])
                for topic, kind in self.kinds.items()}
            for topic, stamp, data in self.messages:
                writer.write(connections[topic], stamp, data)


def check_with_rosbags(path, recorder, store):
    """Every byte, count, time, definition, hash and profile."""
    with Reader(path) as reader:
        assert reader.message_count == len(recorder.messages)
        for connection in reader.connections:
            assert connection.msgtype == recorder.kinds[connection.topic]
            assert connection.digest == store.hash_rihs01(connection.msgtype)
            assert connection.ext.offered_qos_profiles == [recorder.qos[connection.topic]]
        read = sorted((c.topic, stamp, bytes(data)) for c, stamp, data in reader.messages())
        assert read == sorted(recorder.messages), "the bag holds other bytes than were heard"
        for connection, _, data in reader.messages():
            store.deserialize_cdr(data, connection.msgtype)


def check_with_mcap(path, recorder):
    """The definitions in the file are enough to read it; values as rclpy has them."""
    heard = defaultdict(list)
    for topic, _, data in recorder.messages:
        heard[topic].append(data)
    with next(path.glob("*.mcap")).open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, _, message in reader.iter_decoded_messages():
            data = heard[channel.topic].pop(0)
            if schema.name == "carom/msg/CircleStates":
                theirs = deserialize_message(data, CircleStates)
                assert [(c.id, c.x, c.vy, c.mass) for c in message.circles] == \
                    [(c.id, c.x, c.vy, c.mass) for c in theirs.circles]
    assert not any(heard.values()), "messages are missing"


def check_answers(path, recorder, storage, folder):
    """carom reads the recording, and answers it as the node did, bit by bit."""
    out = folder / f"answers-{storage}"
    run = subprocess.run([BINARY, "run", "teams", "--from", path, "--out", out], capture_output=True,
                         text=True, check=True)
    assert run.stdout.startswith("30 messages, 30 of them with 30 contacts, 0 refusals"), run.stdout
    kinds = {"/contacts": Contacts, "/corrected_velocities": CircleVelocities}
    asked = {nanoseconds(deserialize_message(data, CircleStates).header.stamp)
             for topic, _, data in recorder.messages if topic == "/circle_states"}
    live = {(topic, data) for topic, _, data in recorder.messages if topic in kinds
            and nanoseconds(deserialize_message(data, kinds[topic]).header.stamp) in asked}
    with Reader(out) as reader:
        answers = {(connection.topic, bytes(data)) for connection, _, data in reader.messages()}
    assert len(answers) == 60 and answers == live, "answers offline differ from those live"


def ask(client, recorder):
    """Circle states that the recorder hears too: it is told of them by who publishes."""
    for k in range(30):
        circles = [Circle(1, 0.001 * k, 50.0, 1.0, 0.25, 0.5, 1.0),
                   Circle(2, 0.75, 50.125, -1.0, 1 / 3, 0.5, 3.0)]
        message = circle_states(circles, "map", next_stamp())
        client.publisher.publish(message)
        stamp = nanoseconds(message.header.stamp)
        client.answer(stamp)
        recorder.messages.append(("/circle_states", time.time_ns(), serialize_message(message)))


def main():
    store = types()
    with tempfile.TemporaryDirectory() as name, Carom("teams") as carom, Client() as client:
        folder = Path(name)
        recorder = Recorder(client)
        wait_until(recorder.open, "everything that carom publishes in the graph")
        recorder.kinds["/circle_states"] = "carom/msg/CircleStates"
        recorder.qos["/circle_states"] = recorder.qos["/contacts"]
        drive = client.node.create_publisher(Twist, "pucks/ball/cmd_vel", 10)
        twist = Twist()
        twist.linear.x = 3.0
        client.connect()
        ask(client, recorder)
        wanted = PUBLISHED - {"/parameter_events"}
        wait_until(lambda: wanted <= set(recorder.count()), "a message on every topic",
                   each=lambda: drive.publish(twist))
        carom.stop()
        # No more messages come: the recording is complete.
        for storage in (StoragePlugin.MCAP, StoragePlugin.SQLITE3):
            path = folder / storage.name.lower()
            recorder.write(path, storage, store)
            check_with_rosbags(path, recorder, store)
            check_answers(path, recorder, storage.name.lower(), folder)
        check_with_mcap(folder / "mcap", recorder)
        print(f"recorded, read back and answered: {dict(recorder.count())}")


if __name__ == "__main__":
    main()
