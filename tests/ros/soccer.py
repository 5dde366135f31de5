"""Robot soccer's tracked frames: a tracker's come back corrected, and the arena tells its own."""

import copy
from math import hypot, nan

from ateam_msgs.msg import VisionStateBall, VisionStateRobot
from carom.msg import Crashes
from geometry_msgs.msg import Twist
from harness import QOS, Carom, Client, Heard, assert_close, scene, wait_until
from rclpy.serialization import serialize_message
from robocup_ssl_msgs.msg import (
    KickedBall, RobotId, TrackedBall, TrackedFrame, TrackedRobot, Vector2, Vector3)

YELLOW, BLUE = 1, 2
FLOAT = 1e-6


def robot(team, number, x, y, vx, vy):
    return TrackedRobot(
        robot_id=RobotId(id=number, team_color=team), pos=Vector2(x=x, y=y), orientation=0.5,
        vel=[Vector2(x=vx, y=vy)], vel_angular=[0.25], visibility=[1.0])


def ball(x, y, vx, vy):
    return TrackedBall(pos=Vector3(x=x, y=y, z=0.0), vel=[Vector3(x=vx, y=vy, z=0.5)],
                       visibility=[1.0])


def a_tracker():
    """Radius and mass are the league's: 0.09 m and 2.5 kg, 0.0215 m and 0.046 kg."""
    parameters = ["-p", "tracked_in:=detection_tracked"]
    with Client() as client, Carom("resolver", "--ros-args", *parameters) as carom:
        told = Heard(client, TrackedFrame, "detection_tracked_corrected")
        publisher = client.node.create_publisher(TrackedFrame, "detection_tracked", QOS)
        frame = TrackedFrame(frame_number=7, timestamp=12.5, capabilities=[2])
        # Head on, in contact by 1 mm; a third far away; one that is not seen; one without velocity.
        frame.robots = [
            robot(BLUE, 3, 0.0, 0.0, 1.0, 0.5), robot(YELLOW, 3, 0.179, 0.0, -1.0, 0.0),
            robot(BLUE, 4, 2.0, 0.0, 1.0, 0.0), robot(YELLOW, 4, 2.1, 0.0, -1.0, 0.0),
            robot(YELLOW, 5, 2.0, 0.1, 0.0, -1.0)]
        frame.robots[3].visibility = [0.0]
        frame.robots[4].vel = []
        # A ball at rest in the way of blue 6.
        frame.robots.append(robot(BLUE, 6, -2.0, 0.0, 2.0, 0.0))
        frame.balls = [ball(-2.0 + 0.111, 0.0, 0.0, 0.0)]
        frame.kicked_ball = [KickedBall(start_timestamp=3.0, stop_timestamp=[4.0])]
        wait_until(lambda: told, "a corrected frame", each=lambda: publisher.publish(frame))
        seen = told[-1]
        assert_close(seen.robots[0].vel[0].x, -1.0, FLOAT, "equal masses change velocities")
        assert_close(seen.robots[0].vel[0].y, 0.5, FLOAT, "across the line of centres nothing")
        assert_close(seen.robots[1].vel[0].x, 1.0, FLOAT, "the other one")
        # u = (m1 v1 + m2 v2) / (m1 + m2), and 2 u - v.
        mean = 2.5 * 2.0 / 2.546
        assert_close(seen.robots[5].vel[0].x, 2 * mean - 2.0, FLOAT, "a robot from a ball")
        assert_close(seen.balls[0].vel[0].x, 2 * mean, FLOAT, "a ball from a robot")
        # All the rest is as the tracker has told it.
        rest = copy.deepcopy(seen)
        for k in (0, 1, 5):
            rest.robots[k].vel = frame.robots[k].vel
        rest.balls[0].vel[0].x, rest.balls[0].vel[0].y = 0.0, 0.0
        assert serialize_message(rest) == serialize_message(frame), (rest, frame)
        # Bad things are named; the others are served.
        frame.robots[2].pos.x = nan
        frame.robots.append(robot(3, 1, 5.0, 0.0, 0.0, 0.0))
        frame.robots.append(robot(BLUE, 16, 6.0, 0.0, 0.0, 0.0))
        frame.frame_number = 8
        wait_until(lambda: told[-1].frame_number == 8, "the next frame",
                   each=lambda: publisher.publish(frame))
        assert_close(told[-1].robots[0].vel[0].x, -1.0, FLOAT, "as before")
        carom.wait_for_line("ERROR", "detection_tracked", "robot 4 of team 2", "finite")
        carom.wait_for_line("ERROR", "robot 1 of team 3")
        carom.wait_for_line("ERROR", "robot 16 of team 2")


def an_arena():
    """A scene with teams tells what a tracker would."""
    states = ["--ros-args", "-p", "team_states:=true"]
    with Client() as client, Carom("ssl-b", *states) as carom:
        told = Heard(client, TrackedFrame, "detection_tracked")
        ball = Heard(client, VisionStateBall, "ball")
        one = Heard(client, VisionStateRobot, "blue_team/robot0")
        other = Heard(client, VisionStateRobot, "yellow_team/robot5")
        drive = client.node.create_publisher(Twist, "pucks/blue_0/cmd_vel", QOS)
        wait_until(lambda: told, "a frame")
        frame = told[-1]
        teams = sorted((r.robot_id.team_color, r.robot_id.id) for r in frame.robots)
        assert teams == [(team, k) for team in (YELLOW, BLUE) for k in range(6)], teams
        assert len(frame.balls) == 1

        def first(frame):
            return next(r for r in frame.robots
                        if (r.robot_id.team_color, r.robot_id.id) == (BLUE, 0))

        twist = Twist()
        twist.linear.x, twist.angular.z = 0.25, 0.5
        wait_until(lambda: abs(first(told[-1]).vel[0].x) > 0.2 and
                   first(told[-1]).vel_angular[0] > 0.4,
                   "it is driven", each=lambda: drive.publish(twist), period_s=0.02)
        numbers = [frame.frame_number for frame in told]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers))), "none is left out"
        times = [frame.timestamp for frame in told]
        assert times == sorted(set(times))
        wait_until(lambda: ball and one and other, "states of their own")
        assert ball[-1].visible and one[-1].visible and other[-1].visible
        wait_until(lambda: one[-1].twist_body.linear.x > 0.2, "its own frame",
                   each=lambda: drive.publish(twist), period_s=0.02)
        speed = one[-1].twist.linear
        assert_close(hypot(speed.x, speed.y), hypot(one[-1].twist_body.linear.x,
                                                    one[-1].twist_body.linear.y), 1e-9, "m/s")
        assert carom.alive()


RAM = """
method: ticks
tick_s: 0.001
restitution: 0.3
robots:
  - {name: blue, team: blue, radius: 0.09, mass: 2.5, places: [[0, 0, 0]],
     drive: {model: holonomic, speed_max: 3.0, acceleration_max: 6.0}}
  - {name: yellow, team: yellow, radius: 0.09, mass: 2.5, places: [[2, 0, 0]]}
"""


def a_crash():
    """Who runs into a robot of the others is named, with both speeds."""
    with Client() as client, Carom(scene(RAM)):
        crashes = Heard(client, Crashes, "crashes")
        drive = client.node.create_publisher(Twist, "pucks/blue_0/cmd_vel", QOS)
        twist = Twist()
        twist.linear.x = 3.0
        wait_until(lambda: crashes, "a crash", each=lambda: drive.publish(twist), period_s=0.02)
        crash = crashes[0].crashes[0]
        blue_is_first = crash.a < crash.b
        speeds = (crash.speed_a, crash.speed_b) if blue_is_first else (crash.speed_b, crash.speed_a)
        faults = (crash.fault_a, crash.fault_b) if blue_is_first else (crash.fault_b, crash.fault_a)
        assert 1.5 < speeds[0] <= 3.0 and speeds[1] == 0.0, speeds
        assert_close(crash.approach_speed, speeds[0], 1e-12, "head on")
        assert faults == (True, False), faults
        assert_close(crash.point_x, 2.0 - 0.09, 1e-9, "where they touched")


def main():
    a_tracker()
    an_arena()
    a_crash()


if __name__ == "__main__":
    main()
