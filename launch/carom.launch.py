"""Starts carom: `ros2 launch carom carom.launch.py scene:=teams namespace:=/arena rviz:=true`."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    """One node, and RViz beside it if that is asked for."""
    rviz = Path(get_package_share_directory("carom"), "config", "carom.rviz")
    namespace = LaunchConfiguration("namespace")
    parameters = {
        "scene": LaunchConfiguration("scene"),
        "rate": ParameterValue(LaunchConfiguration("rate"), value_type=float),
    }
    return LaunchDescription([
        DeclareLaunchArgument("scene", default_value="arena",
                              description="a scene file, or the name of a shipped scene"),
        DeclareLaunchArgument("rate", default_value="1.0",
                              description="simulated seconds in a second; 0 = as fast as possible"),
        DeclareLaunchArgument("namespace", default_value="/"),
        DeclareLaunchArgument("rviz", default_value="false"),
        Node(package="carom", executable="carom", name="carom", namespace=namespace,
             output="screen", parameters=[parameters]),
        Node(package="rviz2", executable="rviz2", namespace=namespace,
             arguments=["-d", str(rviz)], condition=IfCondition(LaunchConfiguration("rviz"))),
    ])
