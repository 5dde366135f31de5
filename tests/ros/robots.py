"""Robots with standard messages alone: odom in, what they must do out, each in its own frame."""

from math import cos, pi, sin

from geometry_msgs.msg import TwistStamped
from harness import QOS, Carom, Client, Heard, assert_close, next_stamp, wait_until
from nav_msgs.msg import Odometry

ROBOTS = ("r1", "r2")
PARAMETERS = ["-p", "robots:=[r1, r2]", "-p", "r1.radius:=0.5", "-p", "r2.radius:=0.5",
              "-p", "r1.mass:=1.0", "-p", "r2.mass:=3.0"]


def odom(name, x, y, yaw, forward, left=0.0):
    message = Odometry()
    stamp = next_stamp()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 10**9)
    message.header.frame_id, message.child_frame_id = "map", f"{name}/base_link"
    message.pose.pose.position.x, message.pose.pose.position.y = float(x), float(y)
    message.pose.pose.orientation.z = sin(yaw / 2)
    message.pose.pose.orientation.w = cos(yaw / 2)
    message.twist.twist.linear.x, message.twist.twist.linear.y = float(forward), float(left)
    message.twist.twist.angular.z = 0.25
    return message


def main():
    with Client() as client, Carom("resolver", "--ros-args", *PARAMETERS) as carom:
        answers = {name: Heard(client, TwistStamped, f"{name}/corrected_velocity")
                   for name in ROBOTS}
        publishers = {}
        for name in ROBOTS:
            publishers[name] = client.node.create_publisher(Odometry, f"{name}/odom", QOS)
        # r1 looks along y and drives along -y in reverse; r2 looks along -x and stands below it.
        reports = {"r1": odom("r1", 0, 1, pi / 2, -2.0), "r2": odom("r2", 0, 0, pi, 0.0)}

        def tell():
            for name, message in reports.items():
                publishers[name].publish(message)

        wait_until(lambda: all(answers.values()), "both robots are told what to do", each=tell)
        r1, r2 = answers["r1"][-1], answers["r2"][-1]
        # One dimension, along y: masses 1 and 3, speeds -2 and 0 become 1 and -1.
        assert_close(r1.twist.linear.x, 1.0, 1e-12, "r1 forward, which is along y")
        assert_close(r1.twist.linear.y, 0.0, 1e-12, "r1 sideways")
        assert_close(r2.twist.linear.x, 0.0, 1e-12, "r2 forward")
        assert_close(r2.twist.linear.y, 1.0, 1e-12, "r2 to its left, which is along -y")
        assert (r1.header.frame_id, r2.header.frame_id) == ("r1/base_link", "r2/base_link")
        assert r1.twist.angular.z == 0.25, "it turns as before"
        bad = odom("r1", float("nan"), 1, 0, 0)
        publishers["r1"].publish(bad)
        carom.wait_for_line("ERROR", "r1/odom", "position.x")
        assert carom.alive()


if __name__ == "__main__":
    main()
