"""The examples of README.md, as a reader types them: messages published, the answers compared."""

import os
import re
import shlex
from pathlib import Path

import yaml
from carom.msg import CircleState, CircleStates
from geometry_msgs.msg import Twist
from harness import ROOT, Carom, Client, assert_close, nanoseconds, next_stamp, wait_until

README = Path(os.environ.get("CAROM_README", ROOT / "README.md"))
TOLERANCE = 1e-12


def block(marker):
    """The fenced block that follows a marker."""
    pattern = rf"<!-- {marker} -->\s*```\w*\n(.*?)^```"
    found = re.search(pattern, README.read_text(), re.DOTALL | re.MULTILINE)
    assert found, f"{README}: no fenced block after <!-- {marker} -->"
    return found[1]


def published(marker):
    """Topic, type and values of a `ros2 topic pub` command, split as a shell does."""
    words = shlex.split(block(marker))
    assert words[:3] == ["ros2", "topic", "pub"], words
    start = next(index for index, word in enumerate(words) if word.startswith("/"))
    topic, kind, values = words[start:]
    return topic, kind, yaml.safe_load(values)


def fill(message, values):
    """Sets fields by name, as ros2cli does; the only array of the message is of circles."""
    for name, value in values.items():
        current = getattr(message, name)
        if name == "header" and value == "auto":
            current.stamp.sec, current.stamp.nanosec = divmod(next_stamp(), 1_000_000_000)
        elif isinstance(value, dict):
            fill(current, value)
        elif isinstance(value, list):
            setattr(message, name, [fill(CircleState(), item) for item in value])
        else:
            # YAML says 1 where the message wants 1.0.
            setattr(message, name, type(current)(value))
    return message


def compare(message, expected, where):
    """The echoed text names each field of the message, with its value."""
    fields = message.get_fields_and_field_types()
    assert list(fields) == list(expected), f"{where}: fields {list(fields)}, not {list(expected)}"
    for name, value in expected.items():
        actual, label = getattr(message, name), f"{where}.{name}"
        if isinstance(value, dict):
            compare(actual, value, label)
        elif isinstance(value, list):
            assert len(actual) == len(value), f"{label}: {len(actual)} items, not {len(value)}"
            for index, pair in enumerate(zip(actual, value)):
                compare(*pair, f"{label}[{index}]")
        elif isinstance(value, (int, float)):
            assert_close(actual, value, TOLERANCE, label)
        else:
            assert actual == value, f"{label}: {actual!r}, not {value!r}"


def resolver():
    """The example of two circles: its answer is the text that README shows."""
    topic, kind, values = published("pub-example")
    assert (topic, kind) == ("/circle_states", "carom/msg/CircleStates"), f"{topic} {kind}"
    message = fill(CircleStates(), values)
    expected = next(yaml.safe_load_all(block("echo-example")))
    with Carom(), Client() as client:
        client.connect()
        client.publisher.publish(message)
        stamp = nanoseconds(message.header.stamp)
        client.answer(stamp, "answer to the example")
        (answer,) = client.inboxes["corrected_velocities"].by_stamp[stamp]
    print(answer)
    compare(answer, expected, "corrected_velocities")


def drive():
    """The example that drives a puck of the default arena: it has the velocity asked for."""
    topic, kind, values = published("drive-example")
    assert kind == "geometry_msgs/msg/Twist", kind
    twist = fill(Twist(), values)
    wanted = (twist.linear.x, twist.linear.y)
    with Carom(), Client(topics=("arena_states",)) as client:
        publisher = client.node.create_publisher(Twist, topic, 10)
        states = client.inboxes["arena_states"].messages

        def obeyed():
            return any((c.vx, c.vy) == wanted for m in states for c in m.circles)

        wait_until(obeyed, f"a puck with the velocity {wanted}",
                   each=lambda: publisher.publish(twist))


def main():
    resolver()
    drive()


if __name__ == "__main__":
    main()
