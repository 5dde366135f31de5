"""Markers: one a puck with a stable id, gone when the puck is, and a list for thousands."""

from harness import Carom, Client, Heard, scene, wait_until
from simulation import Simulation
from visualization_msgs.msg import Marker, MarkerArray


def pictures_of(client):
    """All that is drawn."""
    return Heard(client, MarkerArray, "markers", of=lambda message: message.markers)


def pucks(markers, action=Marker.ADD):
    return {m.id: m for m in markers if m.ns == "pucks" and m.action == action}


def check_few(client):
    pictures = pictures_of(client)
    with Carom("head_on"):
        wait_until(lambda: pictures, "a picture")
        left = pucks(pictures[-1])[1_000_000]
        assert left.type == Marker.CYLINDER and left.scale.x == 0.25, left
        assert abs(left.color.b - 0xb2 / 255) < 1e-6 and left.color.a == 1.0, left.color
        assert left.header.frame_id == "map"
        walls, = [m for m in pictures[-1] if m.ns == "walls"]
        assert walls.type == Marker.LINE_STRIP and len(walls.points) == 5, walls
        wait_until(lambda: len(pictures) > 20, "more pictures")
        assert all(set(pucks(p)) == {1_000_000, 1_000_001} for p in pictures), "stable ids"
        assert Simulation(client).verdict("DeleteEntity", entity="right") == 1
        wait_until(lambda: any(pucks(p, Marker.DELETE) for p in pictures), "a deletion")
        wait_until(lambda: list(pucks(pictures[-1])) == [1_000_000], "the other stays")


def check_many(client):
    pictures = pictures_of(client)
    text = ("walls: {x: [0, 50], y: [0, 50]}\nbatches:\n"
            "  - {name: gas, count: 2000, seed: 1, radius: 0.2, speed: 1.0, colour: red}\n")
    with Carom(scene(text, "many.yaml")):
        wait_until(lambda: pictures, "a picture")
        spheres, = pucks(pictures[-1]).values()
        assert spheres.type == Marker.SPHERE_LIST and len(spheres.points) == 2000, spheres.type
        assert len(spheres.colors) == 2000 and spheres.colors[0].r == 1.0


def main():
    with Client() as client:
        check_few(client)
        check_many(client)


if __name__ == "__main__":
    main()
