"""What `colcon build` installs: the node as `ros2 run` finds it, its messages, what it needs."""

import os
from pathlib import Path

import carom.msg
from ament_index_python.packages import get_package_prefix, get_package_share_directory

from harness import BINARY, Carom, Circle, Client

HEAD_ON = [Circle(1, 0.0, 0.0, 1.0, 0.0, 0.5, 1.0), Circle(2, 1.0, 0.0, -1.0, 0.0, 0.5, 1.0)]


def check_executable():
    """`ros2 run carom carom` takes the one executable under lib/carom of the package's prefix."""
    folder = Path(get_package_prefix("carom"), "lib", "carom")
    executables = [path for path in folder.iterdir() if os.access(path, os.X_OK)]
    assert executables == [Path(BINARY)], f"{folder}: {executables}"


def check_share():
    """The launch file compiles and names a layout that is there: there are no wheels of launch."""
    share = Path(get_package_share_directory("carom"))
    launch = share / "launch" / "carom.launch.py"
    compile(launch.read_text(), launch, "exec")
    for name in ["config/carom.rviz", "config/arena.yaml", "msg/CircleStates.msg", "package.xml"]:
        assert (share / name).is_file(), f"{share / name} is missing"


def check_answer():
    """The installed messages carry circles to the installed node and its answer back."""
    prefix = get_package_prefix("carom")
    assert Path(carom.msg.__file__).is_relative_to(prefix), f"{carom.msg.__file__}: not {prefix}"
    with Carom("resolver"), Client() as client:
        client.connect()
        answer = client.ask(HEAD_ON)
        assert answer.velocities == {1: (-1.0, 0.0), 2: (1.0, 0.0)}, answer.velocities


check_executable()
check_share()
check_answer()
