"""A simulated puck against a circle that someone else owns: heavy, at rest, in its way.

The puck (1 kg) bounces as from any circle of 10 kg; the observed circle is only told its velocity.
"""

from fractions import Fraction

from harness import Carom, Circle, Client, assert_close, scene, wait_until

PUCK, OBSERVED = 7, 42
SPEED, PUCK_MASS, OBSERVED_MASS = Fraction(1, 2), 1, 10
PUCK_RADIUS, OBSERVED_RADIUS = 0.125, 0.25
PUCK_AFTER = SPEED * Fraction(PUCK_MASS - OBSERVED_MASS, PUCK_MASS + OBSERVED_MASS)
OBSERVED_AFTER = SPEED * Fraction(2 * PUCK_MASS, PUCK_MASS + OBSERVED_MASS)
SCENE = f"""\
name: one puck in free space
pucks:
  - {{name: puck, position: [0.0, 0.0], velocity: [{float(SPEED)}, 0.0], radius: {PUCK_RADIUS},
     mass: {float(PUCK_MASS)}, id: {PUCK}}}
"""
PERIOD_S = 1 / 50
TOLERANCE = 1e-12


def main():
    with Carom(scene(SCENE)), Client(topics=list(Client.TYPES)) as client:
        client.connect()
        states = client.inboxes["arena_states"].messages
        told = client.inboxes["corrected_velocities"].messages
        wait_until(lambda: states, "arena_states")
        # A second ahead of the puck, wherever discovery has let it come to.
        x = states[-1].circles[0].x + PUCK_RADIUS + OBSERVED_RADIUS + float(SPEED)
        obstacle = Circle(OBSERVED, x, 0, 0, 0, OBSERVED_RADIUS, OBSERVED_MASS)

        def after():
            return [m.circles[0] for m in states if m.circles[0].vx != float(SPEED)]

        def corrected():
            return [v for m in told for v in m.velocities if v.id == OBSERVED]

        # Published on for a while after the bounce: it must not be collided again.
        wait_until(lambda: len(after()) >= 30 and corrected(), "the bounce",
                   each=lambda: client.publish([obstacle]), period_s=PERIOD_S)

        for puck in after():
            assert_close(puck.vx, PUCK_AFTER, TOLERANCE, "vx of the puck after the bounce")
            assert_close(puck.vy, 0, TOLERANCE, "vy of the puck after the bounce")
            assert puck.x < x - PUCK_RADIUS - OBSERVED_RADIUS + 1e-9, f"inside: x = {puck.x}"
        for velocity in corrected():
            assert_close(velocity.vx, OBSERVED_AFTER, TOLERANCE, "vx told to the observed circle")
            assert_close(velocity.vy, 0, TOLERANCE, "vy told to the observed circle")
        for message in states:
            ids = [circle.id for circle in message.circles]
            assert ids == [PUCK], f"arena_states of {ids}: only simulated pucks belong there"


if __name__ == "__main__":
    main()
