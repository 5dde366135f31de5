"""Payloads that are no message of their topic: refused, counted by cause, and the next one served.

rclpy publishes bytes as they are, which makes it the raw writer of this test. The first four bytes
name the encoding: 00 01 00 00 is CDR, little-endian.
"""

import random
import struct
import time
from math import nan

from carom.msg import CircleStates, Contacts, ErrorReport
from geometry_msgs.msg import Twist
from harness import Carom, Circle, Client, Heard, circle_states, next_stamp, wait_until
from nav_msgs.msg import Odometry
from parameters import Parameters
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

SEED, RANDOM = 9, 300
GOOD = [Circle(1, 0, 0, 1, 0, 1, 1), Circle(2, 2, 0, -1, 0, 1, 1)]
HUGE = struct.pack("<I", 0xffffffff)
FRAME = b"map\0"
# Of a CircleStates: the encoding and the stamp lie before the length of the frame.
FRAME_AT = 12


def big_endian():
    """A good CircleStates as a machine with the other byte order writes it."""
    stamp = next_stamp()
    head = struct.pack(">iII", stamp // 10**9, stamp % 10**9, 4) + FRAME
    # part, parts, count; the first id ends at a multiple of 8, as its numbers must begin.
    body = struct.pack(">III", 0, 0, len(GOOD))
    for circle in GOOD:
        body += struct.pack(">I", circle.id)
        body += bytes(-(len(head) + len(body)) % 8) + struct.pack(">6d", *circle[1:])
    return stamp, b"\0\0\0\0" + head + body


def undecodable(message):
    """A good message in an unknown encoding, and cut: DDS fills up to a multiple of four bytes."""
    yield b"\0\xff\0\0" + message[4:]
    yield from (message[:length] for length in range(4, len(message) - 3, 4))


def circle_payloads(message):
    """The same at every length, with lengths of fields that are not there, and with no text."""
    yield from undecodable(message)
    yield from (message[:length] for length in range(5, len(message) - 3) if length % 4)
    yield message[:FRAME_AT] + HUGE + message[FRAME_AT + 4:]
    yield message[:FRAME_AT + 12 + 4] + HUGE + message[FRAME_AT + 12 + 8:]
    yield message.replace(FRAME, b"\xff\xfe\xc0\0")


class Reports:
    """What the node says that it has refused, since its start."""

    def __init__(self, client):
        self.reports = Heard(client, ErrorReport, "error_report")

    def refused(self):
        last = self.reports[-1]
        counts = zip(last.refused_causes, last.refused_counts)
        return {cause: count for cause, count in counts if count}

    def wait_for(self, what, **counts):
        wait_until(lambda: self.reports, "a report")
        wait_until(lambda: self.refused() == counts,
                   f"{what}: {counts} refused")


def send_all(client, publisher, payloads):
    """One at a time, so that none is overwritten unread."""
    for payload in payloads:
        publisher.publish(payload)
        client.ask(client.probe(), f"after {payload[:80]!r}")
    return len(payloads)


def check_circles(carom, client, reports):
    good = serialize_message(circle_states(GOOD, "map", next_stamp()))
    count = send_all(client, client.publisher, list(circle_payloads(good)))
    reports.wait_for("circle_states", undecodable=count)
    carom.wait_for_line("ERROR", "circle_states", "undecodable")
    # DDS drops a payload that has no encoding, and counts it as lost; the last bytes of a mass are
    # filled up with zeros.
    wrong = [b"", *(good[:-cut] for cut in (1, 2, 3)),
             serialize_message(circle_states([Circle(7, nan, 0, 0, 0, 1, 1)], "map", next_stamp()))]
    dropped = reports.reports[-1].dropped_in
    send_all(client, client.publisher, wrong)
    reports.wait_for("numbers", undecodable=count, out_of_range=3, not_finite=1)
    assert reports.reports[-1].dropped_in > dropped, "an empty payload is not counted"
    client.publisher.publish(good + b"more than there is to read")
    assert client.ask(GOOD, "a good message").velocities == {1: (-1, 0), 2: (1, 0)}
    stamp, message = big_endian()
    client.publisher.publish(message)
    assert client.answer(stamp, "big-endian").velocities == {1: (-1, 0), 2: (1, 0)}
    return count


def check_random(client):
    """Whatever they are read as: the next good message is answered."""
    chance = random.Random(SEED)
    good = serialize_message(circle_states(GOOD, "elsewhere", next_stamp()))
    for _ in range(RANDOM):
        payload = bytearray(good)
        for _ in range(chance.randrange(1, 9)):
            payload[chance.randrange(len(payload))] = chance.randrange(256)
        client.publisher.publish(bytes(payload[:chance.randrange(4, len(payload) + 1)]))
        client.publisher.publish(b"\0\1\0\0" + chance.randbytes(chance.randrange(200)))
        client.connect()


def send_undecodable(client, kind, topic):
    """The same on another topic; how many there were."""
    publisher = client.node.create_publisher(kind, topic, 10)
    wait_until(lambda: publisher.get_subscription_count() > 0, f"a reader of {topic}")
    # A match has two ends, and rclpy tells of one.
    time.sleep(0.5)
    return send_all(client, publisher, list(undecodable(serialize_message(kind()))))


def check_other_topics(client, reports, count):
    """For robots and for the time."""
    for kind, topic in ((Odometry, "r1/odom"), (Clock, "/clock")):
        count += send_undecodable(client, kind, topic)
        reports.wait_for(topic, undecodable=count, out_of_range=3, not_finite=1)
    return count


def check_driven(client):
    """For a driven puck, which moves on."""
    with Carom("arena"):
        reports = Reports(client)
        client.connect()
        count = send_undecodable(client, Twist, "pucks/alice/cmd_vel")
        reports.wait_for("cmd_vel", undecodable=count)


def check_wrong_type(carom, client, reports):
    """Said once, in one line; its bytes are never read as ours."""
    before = reports.refused()["undecodable"]
    with Client(topics=(), publishes=String) as other:
        line = carom.wait_for_line("ERROR", "std_msgs/msg/String", "circle_states", "CircleStates")
        for _ in range(3):
            other.publisher.publish(String(data="hello"))
            client.ask(client.probe(), "beside a publisher of another type")
    assert [said for said in carom.lines if "std_msgs" in said] == [line], "said once"
    # DDS on the side of rclpy looks at the type too, and sends nothing.
    assert reports.refused()["undecodable"] == before, reports.refused()
    print(line)


def check_wrong_type_sent(carom, client, reports):
    """RustDDS does not look at types: what another node of ours sends does arrive."""
    before = reports.refused()["undecodable"]
    rules = ["contacts:=/circle_states", "circle_states:=/other", "corrected_velocities:=/another",
             "error_report:=/other_report"]
    renamed = [word for rule in [*rules, "__node:=other"] for word in ("-r", rule)]
    publisher = client.node.create_publisher(CircleStates, "/other", 10)
    with Carom("resolver", "--ros-args", *renamed), Client((), publishes=Contacts) as reader:
        # Without a reader of the right type nothing would be sent.
        reader.node.create_subscription(Contacts, "circle_states", lambda _: None, 10)
        wait_until(lambda: reports.refused()["undecodable"] > before + 3, "contacts refused",
                   each=lambda: publisher.publish(circle_states(GOOD, "map", next_stamp())))
    said = [line for line in carom.lines if "publishes carom/msg/Contacts" in line]
    assert len(said) == 1 and "carom/msg/CircleStates: ignored" in said[0], said
    assert set(client.ask(GOOD).velocities) == {1, 2}, "the right ones are served"


def main():
    arguments = ["-p", "use_sim_time:=true", "-p", "robots:=[r1]", "-p", "r1.radius:=0.5",
                 "-p", "r1.mass:=1.0"]
    with Carom("resolver", "--ros-args", *arguments) as carom, Client() as client:
        client.connect()
        reports = Reports(client)
        reports.wait_for("the start")
        count = check_circles(carom, client, reports)
        count = check_other_topics(client, reports, count)
        print(f"{count} payloads refused, each counted")
        check_wrong_type(carom, client, reports)
        check_wrong_type_sent(carom, client, reports)
        check_random(client)
        assert Parameters(client).get("stale_after_s"), "parameters are served"
    with Client() as client:
        check_driven(client)


if __name__ == "__main__":
    main()
