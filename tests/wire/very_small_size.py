"""A VSSS team against the node: packets in, the environment out, as FIRASim has them."""

import math

import fira_pb2 as fira
from client import HOST, Asker, Carom, Listener, assert_close, free_ports

SCENE = "vsss-3v3"


def main():
    environment = Listener(fira.Environment)
    port = free_ports(1)[0]
    with Carom(SCENE, "--wire", "--wire-ports", port, "--vision", environment.address) as carom:
        team = Asker(port, fira.Packet)

        def robot(frame, number, blue=True):
            robots = frame.robots_blue if blue else frame.robots_yellow
            return next((robot for robot in robots if robot.robot_id == number), None)

        def until(condition, what, packet=None):
            each = (lambda: team.send(packet.SerializeToString())) if packet else None
            return environment.until(lambda e: condition(e.frame), what, each=each).frame

        first = environment.next()
        assert_close(first.field.length, 1.5, 1e-12, "length of the field, m")
        assert (len(first.frame.robots_blue), len(first.frame.robots_yellow)) == (3, 3)
        assert environment.next().step == first.step + 1
        # Where they shall be: angles in degrees here, in radians in the environment.
        packet = fira.Packet()
        placed = packet.replace.robots.add(yellowteam=False, turnon=True)
        placed.position.robot_id, placed.position.x, placed.position.y = 1, 0.2, -0.3
        placed.position.orientation = 90.0
        packet.replace.ball.x, packet.replace.ball.y, packet.replace.ball.vy = 0.4, 0.1, 0.25
        team.send(packet.SerializeToString())
        frame = until(lambda frame: abs(robot(frame, 1).x - 0.2) < 1e-9, "placed")
        assert_close(robot(frame, 1).orientation, math.pi / 2, 1e-6, "orientation, rad")
        assert 0.0 < frame.ball.vy <= 0.25 and abs(frame.ball.x - 0.4) < 1e-6, frame.ball
        # Both wheels at 10 rad/s, 0.02 m: 0.2 m/s along the heading, which is y.
        packet = fira.Packet()
        packet.cmd.robot_commands.add(id=1, wheel_left=10.0, wheel_right=10.0)
        frame = until(lambda frame: robot(frame, 1).vy > 0.199, "straight on", packet)
        assert abs(robot(frame, 1).vx) < 1e-3
        # Against each other: it turns, 0.4 m/s apart over 0.075 m.
        packet.cmd.robot_commands[0].wheel_left = -10.0
        frame = until(lambda frame: robot(frame, 1).vorientation > 5.3, "turning", packet)
        assert_close(robot(frame, 1).vorientation, 0.4 / 0.075, 1e-6, "rad/s")
        # Gone, and back.
        packet = fira.Packet()
        gone = packet.replace.robots.add(yellowteam=True, turnon=False)
        gone.position.robot_id = 2
        until(lambda frame: robot(frame, 2, blue=False) is None, "gone", packet)
        gone.turnon, gone.position.x, gone.position.y = True, 0.5, 0.4
        until(lambda frame: robot(frame, 2, blue=False), "back", packet)
        # A ball behind the line between the posts is a goal for who attacks there.
        for x, score in ((0.6, (1, 0)), (-0.6, (1, 1)), (0.6, (2, 1))):
            packet = fira.Packet()
            packet.replace.ball.x, packet.replace.ball.y, packet.replace.ball.vx = x, 0.1, 2.0 * x
            team.send(packet.SerializeToString())
            environment.until(lambda e: (e.goals_blue, e.goals_yellow) == score, f"{score}")
        # Whatever is wrong is counted and does no harm.
        packet = fira.Packet()
        packet.cmd.robot_commands.add(id=77, wheel_left=1.0)
        packet.cmd.robot_commands.add(id=0, wheel_left=float("nan"))
        packet.replace.ball.x = float("inf")
        for bad in (packet.SerializeToString(), b"\xff" * 50, b"\x00" * 60_000, b""):
            team.send(bad)
        packet = fira.Packet()
        packet.cmd.robot_commands.add(id=0, wheel_left=10.0, wheel_right=10.0)
        until(lambda frame: robot(frame, 0).vx ** 2 + robot(frame, 0).vy ** 2 > 0.03, "it drives",
              packet)
        assert carom.stop()[0] == 0
        log = "\n".join(carom.lines)
        for told in ("blue_77", "wheel_left is NaN", "this is no Packet", "more than 16384 bytes",
                     "goal for yellow", "blue 2, yellow 1"):
            assert told in log, told
    assert HOST in environment.address


if __name__ == "__main__":
    main()
