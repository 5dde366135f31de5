"""Contacts between circles of different publishers, each one a participant of its own.

Circles 1 and 2 touch, 3 and 4 touch, 5 is alone until a late publisher brings 6.
"""

import time
from contextlib import ExitStack

from harness import Carom, Circle, Client, scene, wait_until

CIRCLES = [
    Circle(1, 0, 0, 1, 0, 1, 1), Circle(2, 2, 0, -1, 0, 1, 1),
    Circle(3, 0, 8, 0.5, 0, 1, 1), Circle(4, 2, 8, -0.5, 0, 1, 1),
    Circle(5, 0, 16, 0.25, 0, 1, 1), Circle(6, 2, 16, -0.25, 0, 1, 1),
]
PARTNER = {1: 2, 2: 1, 3: 4, 4: 3, 5: 6, 6: 5}
STALE_AFTER_S = 0.2


def report(client, circle):
    """Reports a circle and a probe pair; the answer, less the probe: it says that it was heard."""
    answer = client.ask([circle, *client.probe()], f"report of circle {circle.id}")
    probe = {circle.id for circle in client.probe()}
    velocities = dict(answer.velocities)
    assert probe <= velocities.keys(), f"circle {circle.id}: the probe pair is not in the answer"
    contacts = [{c.a, c.b} for c in answer.contacts if not {c.a, c.b} & probe]
    return {k: v for k, v in velocities.items() if k not in probe}, contacts


def check_pair(client, circle):
    """The circle and its partner, of equal mass and head-on, swap their velocities."""
    velocities, contacts = report(client, circle)
    partner = CIRCLES[PARTNER[circle.id] - 1]
    expected = {circle.id: (partner.vx, partner.vy), partner.id: (circle.vx, circle.vy)}
    assert velocities == expected, f"answer to circle {circle.id}: {velocities}"
    assert contacts == [{circle.id, partner.id}], f"contacts of circle {circle.id}: {contacts}"


def report_all(clients):
    for client, circle in zip(clients, CIRCLES):
        report(client, circle)


def check_late_subscriber(publisher):
    """Who subscribes last hears the next answer, without publishing anything."""
    stamps = []
    with Client() as late:
        wait_until(lambda: any(map(late.answered, stamps)), "an answer at the late subscriber",
                   each=lambda: stamps.append(publisher.publish(publisher.probe())))


def check_five_and_late():
    with Carom("resolver"), ExitStack() as stack:
        clients = [stack.enter_context(Client()) for _ in range(5)]
        for client in clients:
            client.connect()
        report_all(clients)
        for _ in ("once", "and again: answers change nothing"):
            for client, circle in zip(clients[:4], CIRCLES):
                check_pair(client, circle)
        assert report(clients[4], CIRCLES[4]) == ({}, []), "circle 5 touches nothing"

        clients.append(stack.enter_context(Client()).connect())
        report_all(clients)
        check_pair(clients[5], CIRCLES[5])
        check_late_subscriber(clients[0])


def check_stale():
    """Circle 1 falls silent: it is answered against until it is stale, and then no more."""
    text = f"name: short memory\nnode: {{stale_after_s: {STALE_AFTER_S}}}\n"
    with Carom(scene(text)), Client() as first, Client() as second:
        first.connect(), second.connect()
        start = time.monotonic()
        report(first, CIRCLES[0])
        check_pair(second, CIRCLES[1])
        while report(second, CIRCLES[1]) != ({}, []):
            assert time.monotonic() < start + 5.0, "circle 1 never goes stale"
        elapsed_s = time.monotonic() - start
        assert elapsed_s >= STALE_AFTER_S, f"circle 1 gone after {elapsed_s} s"
        assert elapsed_s < STALE_AFTER_S + 1.0, f"circle 1 still there after {elapsed_s} s"


def main():
    check_five_and_late()
    check_stale()


if __name__ == "__main__":
    main()
