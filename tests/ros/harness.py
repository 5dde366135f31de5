"""What the rclpy scripts share: the node as a child process, and clients that keep its answers.

No wait is a fixed time: each ends with its condition, or fails when its time-out is over. Only
children started here are ever ended.
"""

import itertools
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import namedtuple
from pathlib import Path

import rclpy
from builtin_interfaces.msg import Time
from carom.msg import CircleState, CircleStates, CircleVelocities, Contacts
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rclpy.signals import SignalHandlerOptions

BINARY = os.environ["CAROM_BIN"]
ROOT = Path(os.environ["CAROM_ROOT"])
# Discovery takes up to 2.5 s on an idle machine; the tests share theirs with a compiler.
TIMEOUT_S = 15.0
# Deep enough for every answer of the longest script, should its reader fall behind.
QOS = QoSProfile(depth=20_000)
# Far from all that the scripts publish, exact in float64.
PROBE_ID, PROBE_Y = 3_000_000_000, -1024.0

CHANGED = threading.Condition()
Circle = namedtuple("Circle", "id x y vx vy radius mass")
Answer = namedtuple("Answer", "header velocities contacts")

# A script that is asked to end must still end its node on the way out.
signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by SIGTERM"))


def wait_until(condition, what, timeout_s=TIMEOUT_S, each=None, period_s=0.1):
    """The first true value of `condition()`; `each`, if given, is called each period meanwhile."""
    deadline = time.monotonic() + timeout_s
    while True:
        if each:
            each()
        with CHANGED:
            value = CHANGED.wait_for(condition, period_s)
        if value:
            return value
        assert time.monotonic() < deadline, f"{what}: not within {timeout_s} s"


def assert_close(actual, expected, tolerance, what):
    """Fails unless |actual - expected| <= tolerance max(1, |expected|); NaN fails too."""
    expected = float(expected)
    near = abs(actual - expected) <= tolerance * max(1.0, abs(expected))
    assert near, f"{what}: {actual!r}, expected {expected!r} within {tolerance}"


def paced(count, rate_hz):
    """Counts at a rate, on absolute deadlines: a late one does not delay the next ones."""
    start = time.monotonic()
    for number in range(count):
        yield number
        time.sleep(max(0.0, start + (number + 1) / rate_hz - time.monotonic()))


class Carom:
    """The node as a child process: `with Carom("resolver") as carom:`."""

    def __init__(self, *arguments):
        self.lines = []
        # Whether a failure of DDS itself is what the script wants to see.
        self.may_fail = False
        self.process = subprocess.Popen(
            [BINARY, "run", *map(str, arguments)],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stderr:
            with CHANGED:
                self.lines.append(line.rstrip("\n"))
                CHANGED.notify_all()

    def alive(self):
        return self.process.poll() is None

    def wait_for_line(self, *patterns):
        """The first line of the log in which every pattern is found."""
        def found():
            return [line for line in self.lines if all(re.search(p, line) for p in patterns)]
        return wait_until(found, f"a line of the log with {patterns}")[0]

    def memory_bytes(self):
        """What of its memory is in RAM."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return 1024 * int(re.search(r"VmRSS:\s*(\d+) kB", status)[1])

    def stop(self, by=signal.SIGINT):
        """Ends the node by a signal: (exit code, seconds that it took)."""
        start = time.monotonic()
        self.process.send_signal(by)
        code = self.process.wait(TIMEOUT_S)
        return code, time.monotonic() - start

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        ended_here = self.alive()
        if ended_here:
            self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(5.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._reader.join(5.0)
        panicked = any("panicked" in line for line in self.lines)
        sound = self.may_fail or not panicked and (
            self.process.returncode == 0 or not ended_here)
        if kind or not sound:
            print("--- log of the node", *self.lines, "---", sep="\n", file=sys.stderr)
        assert kind or sound, f"the node panicked or ended by {self.process.returncode}"


class Inbox:
    """All messages of one topic, in order and by stamp."""

    def __init__(self, field):
        self.field = field
        self.messages = []
        self.by_stamp = {}

    def store(self, message):
        with CHANGED:
            self.messages.append(message)
            self.by_stamp.setdefault(nanoseconds(message.header.stamp), []).append(message)
            CHANGED.notify_all()

    def items(self, stamp):
        """The array sent with a stamp, its parts joined; None while one is missing."""
        parts = sorted(self.by_stamp.get(stamp, []), key=lambda message: message.part)
        if not parts or len(parts) < parts[0].parts:
            return None
        return [item for message in parts for item in getattr(message, self.field)]


class Heard(list):
    """What is heard on one topic, in order; `of` says what is kept of a message."""

    def __init__(self, client, kind, topic, qos=QOS, of=lambda message: message):
        super().__init__()
        self.of = of
        client.node.create_subscription(kind, topic, self.store, qos)

    def store(self, message):
        with CHANGED:
            self.append(self.of(message))
            CHANGED.notify_all()


class Last:
    """Of a topic the last stamp, and how many messages there were: nothing that grows."""

    def __init__(self, client, kind, topic, qos=QOS):
        self.stamp, self.count = None, 0
        client.node.create_subscription(kind, topic, self.store, qos)

    def store(self, message):
        with CHANGED:
            self.stamp, self.count = nanoseconds(message.header.stamp), self.count + 1
            CHANGED.notify_all()


class Client:
    """A DDS participant of its own: publishes circles, keeps what the node says."""

    TYPES = {
        "corrected_velocities": (CircleVelocities, "velocities"),
        "contacts": (Contacts, "contacts"),
        "arena_states": (CircleStates, "circles"),
    }
    ANSWERS = ("corrected_velocities", "contacts")
    _number = itertools.count()

    def __init__(self, topics=ANSWERS, publishes=CircleStates):
        self.number = next(self._number)
        self.context = rclpy.Context()
        # Signals stay with Python, so that SIGINT and SIGTERM unwind through the `with` blocks.
        rclpy.init(context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        self.node = rclpy.create_node(f"client_{self.number}", context=self.context)
        self.publisher = self.node.create_publisher(publishes, "circle_states", QOS)
        self.inboxes = {}
        for topic in topics:
            kind, field = self.TYPES[topic]
            self.inboxes[topic] = Inbox(field)
            self.node.create_subscription(kind, topic, self.inboxes[topic].store, QOS)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self._spinner = threading.Thread(target=self._spin, daemon=True)
        self._spinner.start()

    def _spin(self):
        try:
            self.executor.spin()
        except ExternalShutdownException:
            pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.context.try_shutdown()
        self._spinner.join(5.0)
        self.executor.shutdown()
        self.node.destroy_node()

    def publish(self, circles, frame="map", stamp=None):
        """Publishes circles, given as tuples; returns the stamp in nanoseconds."""
        message = circle_states(circles, frame, next_stamp() if stamp is None else stamp)
        self.publisher.publish(message)
        return nanoseconds(message.header.stamp)

    def answered(self, stamp):
        return all(self.inboxes[topic].items(stamp) is not None
                   for topic in self.ANSWERS if topic in self.inboxes)

    def answer(self, stamp, what="answer"):
        """The answer to the message with this stamp, as soon as all of it is here."""
        wait_until(lambda: self.answered(stamp), what)
        velocities = self.inboxes["corrected_velocities"]
        ids = [v.id for v in velocities.items(stamp)]
        assert ids == sorted(set(ids)), f"{what}: each id once and in order, got {ids}"
        contacts = self.inboxes["contacts"].items(stamp) if "contacts" in self.inboxes else []
        return Answer(velocities.by_stamp[stamp][0].header,
                      {v.id: (v.vx, v.vy) for v in velocities.items(stamp)}, contacts)

    def ask(self, circles, what="answer", frame="map", stamp=None):
        return self.answer(self.publish(circles, frame, stamp), what)

    def probe(self):
        """Two circles in contact, of this client alone, that touch nothing else."""
        first, x = PROBE_ID + 2 * self.number, 64.0 * self.number
        return [Circle(first, x, PROBE_Y, 1.0, 0.0, 1.0, 1.0),
                Circle(first + 1, x + 2.0, PROBE_Y, -1.0, 0.0, 1.0, 1.0)]

    def connect(self, meanwhile=lambda: None):
        """Returns when the node hears this client and is heard: a match has two ends."""
        stamps = []

        def each():
            meanwhile()
            stamps.append(self.publish(self.probe()))

        wait_until(lambda: any(map(self.answered, stamps)), "discovery: an answer to any probe",
                   each=each)
        return self

    def expect_no_answer(self, circles, what):
        """Fails if the node answers: answers come in order, so a later one ends the wait."""
        stamp = self.publish(circles)
        later = self.ask(self.probe(), f"{what}: answer to the next message")
        ids = {circle.id for circle in self.probe()}
        assert set(later.velocities) == ids, f"{what}: the next answer is {later.velocities}"
        for topic, inbox in self.inboxes.items():
            assert stamp not in inbox.by_stamp, f"{what}: answered on {topic}"


def cpu_seconds(pid):
    """CPU time that a process has used so far, user and system."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def nanoseconds(stamp):
    return stamp.sec * 1_000_000_000 + stamp.nanosec


def seconds(stamp):
    return stamp.sec + stamp.nanosec * 1e-9


_last_stamp = 0


def next_stamp():
    """The time now in nanoseconds, never the same twice: it names the answer."""
    global _last_stamp
    _last_stamp = max(_last_stamp + 1, time.time_ns())
    return _last_stamp


def circle_states(circles, frame, stamp):
    """A CircleStates of tuples (id, x, y, vx, vy, radius, mass)."""
    message = CircleStates()
    message.header.frame_id = frame
    message.header.stamp = Time(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000)
    for identity, *numbers in circles:
        x, y, vx, vy, radius, mass = map(float, numbers)
        message.circles.append(
            CircleState(id=identity, x=x, y=y, vx=vx, vy=vy, radius=radius, mass=mass))
    return message


_directory = tempfile.TemporaryDirectory(prefix="carom-test-")


def scene(text, name="scene.yaml"):
    """The path of a new scene file; all of them are gone when the script ends."""
    path = Path(_directory.name, name)
    path.write_text(text)
    return path
