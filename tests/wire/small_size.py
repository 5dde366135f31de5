"""A team, a referee and their tracker against the node, on the protocol of the Small Size League."""

import math
import os
import random
import statistics
import subprocess
import time

import ssl_pb2 as ssl
from client import BINARY, HOST, Asker, Carom, Listener, assert_close, free_ports

SCENE = "ssl-b"
PERIOD_S = 1 / 60
FLOOD_S = 2.0
BLUE, YELLOW = ssl.BLUE, ssl.YELLOW


class Game:
    """The node with all its ports, and everybody who talks with it."""

    def __init__(self, *arguments, speed=1):
        self.vision = Listener(ssl.SSL_WrapperPacket)
        self.tracked = Listener(ssl.TrackerWrapperPacket)
        self.status = {team: Listener(ssl.Robots_Status) for team in (BLUE, YELLOW)}
        told = [listener.address.split(":")[1] for listener in self.status.values()]
        ports = free_ports(4)
        self.arguments = [
            SCENE, "--wire", "--wire-ports", ",".join(map(str, ports + told)),
            "--vision", self.vision.address, "--tracked", self.tracked.address, *arguments]
        self.carom = Carom(*self.arguments)
        self.control = Asker(ports[0], ssl.SimulatorResponse)
        self.blue = Asker(ports[1], ssl.RobotControlResponse)
        self.yellow = Asker(ports[2], ssl.RobotControlResponse)
        self.grsim = Asker(ports[3], ssl.grSim_Packet)
        self.tracked.next()

    def __enter__(self):
        self.carom.__enter__()
        return self

    def __exit__(self, *error):
        self.carom.__exit__(*error)

    def detection(self):
        """The next frame of a camera."""
        while True:
            packet = self.vision.next()
            if packet.HasField("detection"):
                return packet.detection

    def look(self):
        """A frame of a camera of now."""
        self.vision.drain()
        return self.detection()

    def geometry(self):
        while True:
            packet = self.vision.next()
            if packet.HasField("geometry"):
                return packet.geometry

    def frame(self):
        """A tracked frame of now."""
        self.tracked.drain()
        return self.tracked.next().tracked_frame

    def robot(self, number, team=BLUE, frame=None):
        frame = frame or self.frame()
        return next((r for r in frame.robots
                     if (r.robot_id.id, r.robot_id.team) == (number, team)), None)

    def until(self, condition, what, command=None):
        """The first tracked frame of which this holds, while the blue team commands this."""
        def each():
            if command:
                assert self.blue.codes(control(command)) == []
        packet = self.tracked.until(
            lambda packet: condition(packet.tracked_frame), what, each=each)
        return packet.tracked_frame

    def control_codes(self, **fields):
        return self.control.codes(ssl.SimulatorCommand(control=ssl.SimulatorControl(**fields)))

    def config_codes(self, **fields):
        return self.control.codes(ssl.SimulatorCommand(config=ssl.SimulatorConfig(**fields)))

    def place(self, number, team=BLUE, **fields):
        return ssl.TeleportRobot(id=ssl.RobotId(id=number, team=team), **fields)

    def clear(self):
        """Everybody out of the way of the middle, standing."""
        robots = [self.place(r.robot_id.id, r.robot_id.team,
                             x=-4.0 + 0.3 * r.robot_id.id, orientation=0.0,
                             y=2.4 if r.robot_id.team == BLUE else -2.4)
                  for r in self.frame().robots]
        ball = ssl.TeleportBall(x=0.0, y=0.0, vx=0.0, vy=0.0)
        assert self.control_codes(teleport_robot=robots, teleport_ball=ball) == []


def command(number, **fields):
    local = fields.pop("local", None)
    everywhere = fields.pop("everywhere", None)
    wheels = fields.pop("wheels", None)
    robot = ssl.RobotCommand(id=number, **fields)
    move = robot.move_command
    if local:
        move.local_velocity.forward, move.local_velocity.left, move.local_velocity.angular = local
    if everywhere:
        velocity = move.global_velocity
        velocity.x, velocity.y, velocity.angular = everywhere
    if wheels:
        wheel = move.wheel_velocity
        wheel.front_right, wheel.back_right, wheel.back_left, wheel.front_left = wheels
    return robot


def control(*commands):
    return ssl.RobotControl(robot_commands=commands)


def vision_and_geometry(game):
    first = game.detection()
    for number in range(1, 61):
        frame = game.detection()
        assert frame.frame_number == first.frame_number + number
        assert_close(frame.t_capture, first.t_capture + number * PERIOD_S, 2e-6, "time of a frame")
        assert frame.t_sent == frame.t_capture
    assert abs(frame.t_capture - time.time()) < 1.0, "time stamps are those of the wall"
    assert (len(frame.robots_blue), len(frame.robots_yellow), len(frame.balls)) == (6, 6, 1)
    field = game.geometry().field
    assert (field.field_length, field.field_width, field.goal_width) == (9000, 6000, 1000)
    assert {line.name for line in field.field_lines} >= {"TopTouchLine", "LeftPenaltyStretch"}
    assert_close(field.ball_radius, 21.5, 1e-4, "radius of the ball, mm")
    frames = 0
    while not (packet := game.vision.next()).HasField("geometry"):
        frames += 1
    assert 55 <= frames <= 65, f"{frames} frames from one geometry to the next"
    models = packet.geometry.models.straight_two_phase
    assert models.acc_slide < models.acc_roll < 0 < models.k_switch < 1


def teleports(game):
    game.clear()
    robot = game.place(2, x=1.5, y=-0.5, orientation=math.pi / 2, v_x=0.25, v_y=0.0, v_angular=0.5)
    ball = ssl.TeleportBall(x=-0.75, y=0.5, vx=1.0, vy=-0.5)
    game.vision.drain()
    assert game.control_codes(teleport_robot=[robot], teleport_ball=ball) == []
    seen = game.vision.until(
        lambda packet: any(abs(r.x - 1500) < 20 for r in packet.detection.robots_blue), "placed")
    placed = next(r for r in seen.detection.robots_blue if r.robot_id == 2)
    assert_close(placed.y, -500.0, 1.0, "y in mm")
    assert_close(placed.orientation, math.pi / 2, 0.02, "orientation")
    moving = seen.detection.balls[0]
    assert -751 < moving.x < -600 and 420 < moving.y < 501, moving
    ball = game.frame().balls[0]
    assert 0.7 < ball.vel.x < 1.01, "it slides: slower each frame"
    # A ball that rolls from the start loses far less.
    rolls = ssl.TeleportBall(x=0.0, y=0.0, vx=1.0, vy=0.0, roll=True)
    assert game.control_codes(teleport_ball=rolls) == []
    later = game.until(lambda frame: frame.balls[0].pos.x > 0.3, "the ball has rolled on")
    assert_close(later.balls[0].vel.x, 0.92, 0.05, "rolling, m/s")
    # Two robots change places in one packet.
    stand = [game.place(0, x=1.0, y=1.0), game.place(1, x=1.0, y=-1.0)]
    change = [game.place(0, x=1.0, y=-1.0), game.place(1, x=1.0, y=1.0)]
    for places, y in ((stand, 1.0), (change, -1.0)):
        assert game.control_codes(teleport_robot=places) == []
        game.until(lambda frame: abs(game.robot(0, frame=frame).pos.y - y) < 1e-3, "changed")
    # Safely: who stands there makes way, straight away from the ball, and who is near stands still.
    stand = [game.place(0, x=1.0, y=0.05), game.place(1, x=1.25, y=0.0, v_y=1.0),
             game.place(2, x=2.0, y=0.0, v_y=1.0)]
    ball = ssl.TeleportBall(x=1.0, y=0.0, vx=0.0, vy=0.0, teleport_safely=True)
    assert game.control_codes(simulation_speed=0.0) == []
    assert game.control_codes(teleport_robot=stand) == []
    assert game.control_codes(teleport_ball=ball) == []
    assert game.control_codes(simulation_speed=1.0) == []
    frame = game.until(lambda frame: math.hypot(frame.balls[0].pos.x - 1.0, frame.balls[0].pos.y)
                       < 1e-6, "the ball is there")
    made_way, near, far = (game.robot(k, frame=frame) for k in range(3))
    assert_close(made_way.pos.x, 1.0, 1e-6, "x of who made way")
    assert_close(made_way.pos.y, 0.12, 1e-6, "y of who made way")
    assert near.pos.y == 0.0 and far.pos.y > 0.01, (near, far)
    assert game.control_codes(teleport_ball=ssl.TeleportBall(x=99.0, teleport_safely=True)) == [
        "CAROM_NOT_DONE"]
    # Where another stands there is no place.
    assert game.control_codes(teleport_robot=[game.place(1, x=1.0, y=1.0)]) == []
    assert game.control_codes(teleport_robot=[game.place(3, x=1.0, y=1.05)]) == ["CAROM_NOT_DONE"]


def by_force(game):
    """A force draws ball and robot to a place and keeps them there, until it is taken back."""
    game.clear()
    ball = ssl.TeleportBall(x=1.0, y=-0.5, by_force=True)
    robot = game.place(0, x=-3.0, y=1.0, by_force=True)
    game.tracked.drain()
    assert game.control_codes(teleport_ball=ball, teleport_robot=[robot]) == []
    frame = game.until(lambda frame: frame.balls[0].vel.x > 0.1, "it is no jump")
    assert 0.0 < frame.balls[0].pos.x < 1.0

    def is_there(frame):
        seen = game.robot(0, frame=frame)
        return max(abs(frame.balls[0].pos.x - 1.0), abs(frame.balls[0].pos.y + 0.5),
                   abs(seen.pos.x + 3.0), abs(seen.pos.y - 1.0)) < 1e-6

    game.until(is_there, "both are there")
    assert game.blue.codes(control(command(0, everywhere=(1.0, 0.0, 0.0)))) == []
    assert is_there(game.frame())
    end = [game.place(0, by_force=False)]
    assert game.control_codes(teleport_ball=ssl.TeleportBall(), teleport_robot=end) == []
    game.until(lambda frame: game.robot(0, frame=frame).vel.x > 0.3, "it is free again",
               command(0, everywhere=(1.0, 0.0, 0.0)))


def presence(game):
    game.clear()
    assert game.control_codes(teleport_robot=[game.place(4, YELLOW, present=False)]) == []
    game.until(lambda frame: game.robot(4, YELLOW, frame) is None, "gone")
    assert game.yellow.codes(control(command(4, local=(1, 0, 0)))) == ["CAROM_UNKNOWN"]
    assert game.control_codes(teleport_robot=[game.place(4, YELLOW, present=True)]) == [
        "CAROM_UNREADABLE"], "where?"
    there = game.place(4, YELLOW, x=2.0, y=-1.0, orientation=1.0, present=True)
    assert game.control_codes(teleport_robot=[there]) == []
    frame = game.until(lambda frame: game.robot(4, YELLOW, frame), "back")
    robot = game.robot(4, YELLOW, frame)
    assert_close(robot.pos.x, 2.0, 1e-6, "x")
    assert_close(robot.orientation, 1.0, 1e-6, "orientation")
    assert game.yellow.codes(control(command(4, everywhere=(0, 0.5, 0)))) == []
    game.until(lambda frame: game.robot(4, YELLOW, frame).vel.y > 0.2, "it is driven")


def driving(game):
    game.clear()
    turned = [game.place(0, x=0.0, y=1.0, orientation=math.pi / 2)]
    assert game.control_codes(teleport_robot=turned) == []
    answer = game.blue.ask(control(command(0, local=(0.5, 0.0, 0.0))))
    assert [feedback.id for feedback in answer.feedback] == [0] and not answer.errors

    def robot(frame):
        return game.robot(0, frame=frame)

    frame = game.until(lambda frame: robot(frame).vel.y > 0.49, "forward is along its heading",
                       command(0, local=(0.5, 0.0, 0.0)))
    assert abs(robot(frame).vel.x) < 0.01
    game.until(lambda frame: robot(frame).vel.x > 0.49, "x of the field",
               command(0, everywhere=(0.5, 0.0, 0.0)))
    # All wheels the same way turn it where it stands, at v / r.
    frame = game.until(lambda frame: robot(frame).vel_angular > 1.99 and
                       math.hypot(robot(frame).vel.x, robot(frame).vel.y) < 1e-3, "wheels turn it",
                       command(0, wheels=(0.18, 0.18, 0.18, 0.18)))
    assert_close(robot(frame).vel_angular, 2.0, 1e-3, "rad/s")
    # Nobody says anything any more: it stops.
    game.until(lambda frame: abs(robot(frame).vel_angular) < 1e-3, "commands time out")


def specs(game):
    game.clear()
    assert game.control_codes(teleport_robot=[game.place(1, x=0.5, y=1.0)]) == []
    robot = ssl.RobotSpecs(id=ssl.RobotId(id=1, team=BLUE), radius=0.08, mass=2.0, height=0.12)
    robot.limits.vel_absolute_max = 0.4
    robot.max_linear_kick_speed = 2.0
    assert game.config_codes(robot_specs=[robot]) == []
    for _ in range(10):
        game.blue.ask(control(command(1, everywhere=(2.0, 0.0, 0.0))))
        frame = game.frame()
    assert_close(game.robot(1, frame=frame).vel.x, 0.4, 1e-3, "its own limit, m/s")
    seen = next(r for r in game.look().robots_blue if r.robot_id == 1)
    assert_close(seen.height, 120.0, 1e-3, "height, mm")
    robot.radius = -1.0
    assert game.config_codes(robot_specs=[robot]) == ["CAROM_OUT_OF_RANGE"]
    robot.ClearField("radius")
    robot.id.id = 15
    assert game.config_codes(robot_specs=[robot]) == ["CAROM_UNKNOWN"]
    back = ssl.RobotSpecs(id=ssl.RobotId(id=1, team=BLUE), radius=0.09, mass=2.5)
    back.limits.vel_absolute_max = 3.0
    assert game.config_codes(robot_specs=[back]) == []


def to_the_ball(game, number):
    """Stands with the ball at its front, which looks along x."""
    game.clear()
    robot = game.place(number, x=0.0, y=0.0, orientation=0.0)
    ball = ssl.TeleportBall(x=0.09 + 0.0215 + 1e-3, y=0.0, vx=0.0, vy=0.0)
    assert game.control_codes(teleport_ball=ssl.TeleportBall(x=0.5)) == []
    assert game.control_codes(teleport_robot=[robot]) == []
    assert game.control_codes(teleport_ball=ball) == []


def kicks(game):
    to_the_ball(game, 2)
    answer = game.blue.ask(control(command(2, kick_speed=0.0)))
    assert answer.feedback[0].dribbler_ball_contact
    assert game.blue.codes(control(command(2, kick_speed=3.0))) == []
    frame = game.until(lambda frame: frame.balls[0].pos.x > 0.3, "kicked")
    assert 2.4 < frame.balls[0].vel.x < 3.0 and abs(frame.balls[0].vel.y) < 1e-3, frame.balls[0]
    assert not game.blue.ask(control(command(2, kick_speed=0.0))).feedback[0].dribbler_ball_contact
    # Robot 1 kicks no faster than its specs have it.
    to_the_ball(game, 1)
    game.blue.ask(control(command(1, kick_speed=6.0)))
    frame = game.until(lambda frame: frame.balls[0].pos.x > 0.2, "kicked")
    assert frame.balls[0].vel.x <= 2.0
    # A chip stays on the ground, with the horizontal part of it, and says so.
    to_the_ball(game, 2)
    codes = game.blue.codes(control(command(2, kick_speed=4.0, kick_angle=60.0)))
    assert codes == ["CAROM_CHIP_STAYS_ON_GROUND"]
    frame = game.until(lambda frame: frame.balls[0].pos.x > 0.2, "chipped")
    assert 1.5 < frame.balls[0].vel.x <= 2.0
    # A kick waits for the ball, which is at the kicker for less than a frame.
    game.clear()
    robot = game.place(2, x=0.0, y=0.0, orientation=0.0)
    comes = ssl.TeleportBall(x=0.25, y=0.0, vx=-3.0, vy=0.0)
    for number in range(5):
        assert game.control_codes(simulation_speed=0.0) == []
        assert game.control_codes(teleport_robot=[robot], teleport_ball=comes) == []
        assert not game.blue.ask(
            control(command(2, kick_speed=2.8))).feedback[0].dribbler_ball_contact
        assert game.control_codes(simulation_speed=1.0) == []
        frame = game.until(lambda frame: frame.balls[0].vel.x > 0.0, "it comes back")
        assert 2.5 < frame.balls[0].vel.x < 2.81, f"{number}: not kicked: {frame.balls[0]}"


def kicked_ball(game):
    """Who has kicked, from where and when, and where the ball will stop: it stops there."""
    to_the_ball(game, 2)
    frame = game.frame()
    assert not frame.HasField("kicked_ball") and list(frame.capabilities) == [3]
    before = frame.timestamp
    assert game.blue.codes(control(command(2, kick_speed=1.0))) == []
    frame = game.until(lambda frame: frame.HasField("kicked_ball"), "a kick is told")
    kick = frame.kicked_ball
    assert (kick.robot_id.id, kick.robot_id.team) == (2, BLUE)
    assert before <= kick.start_timestamp <= frame.timestamp
    assert_close(kick.pos.x, 0.09 + 0.0215 + 1e-3, 1e-6, "x of the kick, m")
    assert_close(kick.vel.x, 1.0, 1e-6, "speed of the kick, m/s")
    # Slides to 0.64 m/s at 3 m/s^2, then rolls at 0.26 m/s^2.
    way = (1.0 - 0.64 ** 2) / 6.0 + 0.64 ** 2 / 0.52
    lasts = 0.36 / 3.0 + 0.64 / 0.26
    assert_close(kick.stop_pos.x, kick.pos.x + way, 1e-5, "where it will stop, m")
    assert_close(kick.stop_timestamp - kick.start_timestamp, lasts, 1e-5, "when it will stop, s")
    game.blue.ask(control(command(2, kick_speed=0.0)))
    stopped = game.until(lambda frame: not frame.HasField("kicked_ball"), "it stands")
    assert_close(stopped.balls[0].pos.x, kick.stop_pos.x, 1e-5, "where it has stopped, m")
    assert stopped.timestamp - kick.stop_timestamp < 0.1
    # A ball that was put elsewhere was not kicked.
    to_the_ball(game, 2)
    game.blue.ask(control(command(2, kick_speed=1.0)))
    game.until(lambda frame: frame.HasField("kicked_ball"), "another kick")
    assert game.control_codes(teleport_ball=ssl.TeleportBall(x=-1.0, y=1.0)) == []
    game.until(lambda frame: not frame.HasField("kicked_ball"), "no kick any more")


def dribbling(game):
    to_the_ball(game, 2)
    for _ in range(60):
        game.blue.ask(control(command(2, local=(-0.3, 0.0, 0.0), dribbler_speed=1000.0)))
        time.sleep(0.01)
    frame = game.frame()
    robot, ball = game.robot(2, frame=frame), frame.balls[0]
    assert robot.pos.x < -0.05, "it has gone backwards"
    assert_close(ball.pos.x - robot.pos.x, 0.1115, 0.01, "and the ball with it")
    game.blue.ask(control(command(2, local=(0.0, 0.0, 0.0), dribbler_speed=0.0)))


def older_packets(game):
    """grSim's own, which consai and crane send."""
    game.clear()
    packet = ssl.grSim_Packet()
    packet.replacement.robots.add(x=1.0, y=0.5, dir=90.0, id=3, yellowteam=True)
    packet.replacement.ball.x, packet.replacement.ball.y = -1.0, 0.25
    game.grsim.send(packet.SerializeToString())
    frame = game.until(lambda frame: abs(game.robot(3, YELLOW, frame).pos.x - 1.0) < 1e-3, "placed")
    assert_close(game.robot(3, YELLOW, frame).orientation, math.pi / 2, 1e-6, "orientation, rad")
    assert_close(frame.balls[0].pos.y, 0.25, 1e-6, "y of the ball")
    packet = ssl.grSim_Packet()
    packet.commands.timestamp, packet.commands.isteamyellow = 0.0, True
    packet.commands.robot_commands.add(
        id=3, kickspeedx=0.0, kickspeedz=0.0, veltangent=0.5, velnormal=0.0, velangular=0.0,
        spinner=False, wheelsspeed=False)
    game.grsim.send(packet.SerializeToString())
    game.until(lambda frame: game.robot(3, YELLOW, frame).vel.y > 0.3, "forward is along y")


def status(game):
    """After a packet of grSim's the team is told what has changed with its robots, once."""
    to_the_ball(game, 2)

    def send(team, number, **kick):
        packet = ssl.grSim_Packet()
        packet.commands.timestamp, packet.commands.isteamyellow = 0.0, team == YELLOW
        fields = {"kickspeedx": 0.0, "kickspeedz": 0.0} | kick
        packet.commands.robot_commands.add(
            id=number, veltangent=0.0, velnormal=0.0, velangular=0.0, spinner=False,
            wheelsspeed=False, **fields)
        game.grsim.send(packet.SerializeToString())

    def told(team=BLUE):
        return [(robot.robot_id, robot.infrared, robot.flat_kick, robot.chip_kick)
                for robot in game.status[team].next().robots_status]

    def until(expected):
        """The news of robot 2, which does not kick, whose last is this."""
        deadline, seen = time.monotonic() + 15.0, None
        game.status[BLUE].socket.settimeout(0.02)
        while seen != expected:
            assert time.monotonic() < deadline, f"{expected}: last {seen}"
            send(BLUE, 2)
            try:
                seen = next((row[1:] for row in told() if row[0] == 2), seen)
            except TimeoutError:
                pass
        game.status[BLUE].socket.settimeout(15.0)

    send(BLUE, 0)
    assert told() == [(2, True, False, False)]
    send(BLUE, 2, kickspeedx=2.0)
    assert told() == [(2, True, True, False)], "it has still the ball that it has just kicked"
    until((False, False, False))
    to_the_ball(game, 2)
    send(BLUE, 2, kickspeedx=2.0, kickspeedz=2.0)
    assert told() == [(2, True, False, True)]
    until((False, False, False))
    # The other team's is told to the other port, by its own packets.
    game.clear()
    robot = game.place(3, YELLOW, x=0.0, y=0.0, orientation=0.0)
    ball = ssl.TeleportBall(x=0.1125, y=0.0, vx=0.0, vy=0.0)
    assert game.control_codes(teleport_robot=[robot], teleport_ball=ball) == []
    send(YELLOW, 0)
    assert told(YELLOW) == [(3, True, False, False)]
    send(YELLOW, 0)
    send(BLUE, 0)
    time.sleep(0.1)
    for team in (BLUE, YELLOW):
        game.status[team].socket.settimeout(0.0)
        try:
            raise AssertionError(f"nothing has changed: {game.status[team].next()}")
        except BlockingIOError:
            game.status[team].socket.settimeout(15.0)


def refusals(game):
    game.clear()
    good = command(3, local=(0.2, 0.0, 0.0))
    nan, infinite = float("nan"), float("inf")
    for bad, codes in (
            (command(9, local=(1, 0, 0)), ["CAROM_UNKNOWN"]),
            (command(1 << 31, local=(1, 0, 0)), ["CAROM_UNKNOWN"]),
            (command(2, local=(nan, 0, 0)), ["CAROM_NOT_FINITE"]),
            (command(2, everywhere=(0, infinite, 0)), ["CAROM_NOT_FINITE"]),
            (command(2, wheels=(0, 0, 1e9, 0)), ["CAROM_OUT_OF_RANGE"]),
            (command(2, kick_speed=nan), ["CAROM_NOT_FINITE"]),
            (command(2, dribbler_speed=-infinite), ["CAROM_NOT_FINITE"])):
        answer = game.blue.ask(control(bad, good))
        assert [error.code for error in answer.errors] == codes, answer
        assert all(error.message for error in answer.errors)
        assert [feedback.id for feedback in answer.feedback] == [3], "the good one is served"
    bytes_of = control(good, good).SerializeToString()
    assert game.blue.codes(bytes_of[:-3]) == ["CAROM_UNREADABLE"], "truncated"
    assert game.blue.codes(b"\x00" * 65_000) == ["CAROM_OUT_OF_RANGE"], "oversize"
    assert game.control.codes(b"\xff" * 100) == ["CAROM_UNREADABLE"]
    assert len(game.blue.ask(control(*[command(12, local=(1, 0, 0))] * 400)).errors) == 33
    # Whatever it is, it is answered.
    chance = random.Random(8)
    for _ in range(300):
        noise = chance.randbytes(chance.randrange(1, 200))
        game.control.ask(noise)
        game.yellow.ask(noise)
    mutant = bytearray(bytes_of)
    for _ in range(300):
        mutant[chance.randrange(len(mutant))] = chance.randrange(256)
        game.blue.ask(bytes(mutant))
    for fields, codes in (
            ({"teleport_ball": ssl.TeleportBall(x=nan)}, ["CAROM_NOT_FINITE"]),
            ({"teleport_ball": ssl.TeleportBall(x=99.0)}, ["CAROM_NOT_DONE"]),
            ({"teleport_ball": ssl.TeleportBall(x=0.0, z=1.0)}, ["CAROM_UNSUPPORTED"]),
            ({"teleport_ball": ssl.TeleportBall(x=nan, by_force=True)}, ["CAROM_NOT_FINITE"]),
            ({"teleport_robot": [game.place(1, x=infinite)]}, ["CAROM_NOT_FINITE"]),
            ({"teleport_robot": [game.place(40, x=0.0)]}, ["CAROM_UNKNOWN"]),
            ({"teleport_robot": [game.place(1, ssl.UNKNOWN, x=0.0)]}, ["CAROM_UNREADABLE"]),
            ({"simulation_speed": nan}, ["CAROM_NOT_FINITE"]),
            ({"simulation_speed": -1.0}, ["CAROM_OUT_OF_RANGE"])):
        assert game.control_codes(**fields) == codes, fields
    geometry = ssl.SSL_GeometryData()
    geometry.field.CopyFrom(game.geometry().field)
    assert game.config_codes(geometry=geometry) == [], "it is the field that is told"
    geometry.field.field_length = 12000
    answer = game.control.ask(ssl.SimulatorCommand(config=ssl.SimulatorConfig(geometry=geometry)))
    assert [error.code for error in answer.errors] == ["CAROM_UNSUPPORTED"], answer
    assert "field_length 12000, here 9000 mm" in answer.errors[0].message, answer
    assert game.config_codes(vision_port=1 << 20) == ["CAROM_OUT_OF_RANGE"]
    assert game.carom.alive()


def flood(game):
    game.clear()
    before, first = game.carom.memory_bytes(), game.frame()
    start = time.monotonic()
    datagrams = [control(*(command(k, everywhere=(x, 0.0, 0.0)) for k in range(6)))
                 .SerializeToString() for x in (0.0, -0.3)]
    noise = b"\x0a\x7f" * 600
    number = 0
    while (lasted := time.monotonic() - start) < FLOOD_S:
        for datagram in datagrams:
            game.blue.send(datagram)
        game.blue.send(noise)
        number += 3
    # The latest word counts; where the flood has filled the system's queue, it is said again.
    last = control(*(command(k, everywhere=(0.0, 0.25, 0.0)) for k in range(6)))
    packet = game.tracked.until(
        lambda packet: all(game.robot(k, frame=packet.tracked_frame).vel.y > 0.24
                           for k in range(6)),
        "the last word counts", each=lambda: game.blue.send(last.SerializeToString()))
    frame = packet.tracked_frame
    # The answers to all of it are nobody's any more.
    game.blue.socket.close()
    game.blue = Asker(game.blue.to[1], ssl.RobotControlResponse)
    assert frame.timestamp - first.timestamp > 0.8 * lasted, "time has gone on"
    grown = game.carom.memory_bytes() - before
    assert grown < 32 << 20, f"{grown} bytes more"
    print(f"flood: {number / lasted:.0f} datagrams/s for {lasted:.2f} s, {grown >> 10} kB more")


def latency(game):
    """From a command to the first frame in which it shows: within one tick and one period."""
    frames_needed = []
    for _ in range(20):
        stand = game.place(5, x=2.0, y=2.0, v_x=0.0, v_y=0.0)
        game.blue.ask(control(command(5, everywhere=(0.0, 0.0, 0.0))))
        assert game.control_codes(teleport_robot=[stand]) == []
        game.until(lambda frame: game.robot(5, frame=frame).vel.x == 0.0, "it stands")
        # Time stands still when the command comes: the next frame is at most a period later.
        assert game.control_codes(simulation_speed=0.0) == []
        game.tracked.drain()
        game.blue.ask(control(command(5, everywhere=(1.0, 0.0, 0.0))))
        assert game.control_codes(simulation_speed=1.0) == []
        frames = 1
        while game.robot(5, frame=game.tracked.next().tracked_frame).vel.x == 0.0:
            frames += 1
        frames_needed.append(frames)
    # The second only where the first came less than a tick after the command.
    assert max(frames_needed) <= 2 and statistics.median(frames_needed) == 1, frames_needed
    print(f"latency: frames until a command shows: {frames_needed}")


def speed_and_port(game):
    assert game.control_codes(simulation_speed=2.0) == []
    first, start = game.frame(), time.monotonic()
    last = game.until(lambda frame: frame.timestamp > first.timestamp + 2.0, "two seconds")
    passed = (last.timestamp - first.timestamp) / (time.monotonic() - start)
    assert 1.5 < passed < 2.3, f"{passed} simulated seconds in a second"
    assert game.control_codes(simulation_speed=1.0) == []
    other = Listener(ssl.SSL_WrapperPacket)
    old, new = game.vision.socket.getsockname()[1], other.socket.getsockname()[1]
    assert game.config_codes(vision_port=new) == []
    assert other.next()
    assert game.config_codes(vision_port=old) == []


def realism(game):
    game.clear()
    assert game.look().balls[0].x == 0.0, "exact, by default"
    wanted = ssl.RealismConfigErForce(stddev_ball_p=0.005, vision_delay=40_000_000)
    config = ssl.RealismConfig()
    config.custom.add().Pack(wanted)
    assert game.config_codes(realism_config=config) == []
    time.sleep(0.2)
    game.vision.drain()
    frames = [game.detection() for _ in range(120)]
    spread = statistics.pstdev(frame.balls[0].x for frame in frames)
    assert 3.0 < spread < 8.0, f"{spread} mm, asked for 5"
    assert all(abs(frame.t_sent - frame.t_capture - 0.04) < 1e-5 for frame in frames)
    config = ssl.RealismConfig()
    config.custom.add(type_url="type.googleapis.com/RealismConfigOther")
    config.custom.add().Pack(ssl.RealismConfigErForce(robot_command_loss=0.5))
    assert game.config_codes(realism_config=config) == ["CAROM_UNSUPPORTED"] * 2
    off = ssl.RealismConfig()
    off.custom.add().Pack(ssl.RealismConfigErForce(stddev_ball_p=0.0, vision_delay=0))
    assert game.config_codes(realism_config=off) == []


def busy_port(game):
    again = subprocess.run([BINARY, "run", *game.arguments], capture_output=True, text=True,
                           timeout=15)
    said = [line for line in again.stderr.splitlines() if line.startswith("carom: ")]
    assert again.returncode == 1 and len(said) == 1, again
    assert "cannot listen on 127.0.0.1" in said[0] and "--wire-ports" in said[0], said


def ends(game):
    code, took = game.carom.stop()
    assert (code, took < 2.0) == (0, True), (code, took)


def cameras_and_groups():
    """Four cameras, sent to a group on loopback alone."""
    vision = Listener(ssl.SSL_WrapperPacket, group="224.5.23.2")
    ports = ",".join(map(str, free_ports(3)))
    tracked = Listener(ssl.TrackerWrapperPacket)
    with Carom(SCENE, "--wire", "--wire-ports", ports, "--cameras", 4, "--vision", vision.address,
               "--wire-interface", HOST, "--tracked", tracked.address):
        seen = {}
        while len(seen) < 4:
            packet = vision.next()
            if packet.HasField("detection"):
                seen[packet.detection.camera_id] = packet.detection
        robots = [robot for frame in seen.values()
                  for robot in (*frame.robots_blue, *frame.robots_yellow)]
        assert len(robots) == 12, "each is seen by one"
        assert sum(len(frame.balls) for frame in seen.values()) == 1


def recorded():
    """What the wire has done is in the journal of a recording: the run is made again from it."""
    bag = os.path.join(os.environ["WIRE_SCRATCH"], "bag")
    with Game("--record", bag) as game:
        teleports(game)
        by_force(game)
        presence(game)
        driving(game)
        specs(game)
        kicks(game)
        ends(game)
    again = subprocess.run([BINARY, "run", "--from", bag, "--verify"], capture_output=True, text=True,
                           timeout=100)
    print(again.stdout.strip())
    assert again.returncode == 0, again


def main():
    with Game() as game:
        for part in (vision_and_geometry, teleports, by_force, presence, driving, specs, kicks,
                     kicked_ball, dribbling, older_packets, status, refusals, flood, latency,
                     speed_and_port, realism, busy_port, ends):
            start = time.monotonic()
            part(game)
            print(f"{part.__name__}: {time.monotonic() - start:.1f} s", flush=True)
    cameras_and_groups()
    recorded()


if __name__ == "__main__":
    main()
