"""Datagrams that are no RTPS, or nearly: the node stays alive and serves.

A socket of the test joins the domain as a participant that does not exist: under its name go what
the node itself said, cut at every length and altered, and bytes at random from a seed.
"""

import itertools
import os
import random
import socket
import struct
import time

from harness import Carom, Client, wait_until

SEED = int(os.environ.get("CAROM_SEED", "9"))
ALTERED, RANDOM = int(os.environ.get("CAROM_ALTERED", "6000")), 1000
# Ports after RTPS 2.5, 9.6.2.3.
BASE = 7400 + 250 * int(os.environ["ROS_DOMAIN_ID"])
# Of the last participant that the node announces itself to.
STRANGER_PORT = BASE + 10 + 2 * 11
STRANGER = bytes.fromhex("0112") + b"stranger!!"
PAD, INFO_TS = 1, 9
ACKNACK, HEARTBEAT, GAP, NACK_FRAG, HEARTBEAT_FRAG, DATA, DATA_FRAG = 6, 7, 8, 18, 19, 21, 22
METATRAFFIC, USER_TRAFFIC = 0x32, 0x31


def locator_port(announcement, parameter):
    """The port of the first locator of this kind in an announcement."""
    start = announcement.index(struct.pack("<HHI", parameter, 24, 1)) + 8
    return struct.unpack_from("<I", announcement, start)[0]


def submessage(kind, body, flags=1):
    return struct.pack("<BBH", kind, flags, len(body)) + body


def number(value):
    return struct.pack("<iI", value >> 32, value & 0xffffffff)


def told_by_the_stranger(node, entities):
    """One of each submessage, for each pair of a reader and a writer."""
    numbers = number(1) + struct.pack("<II", 32, 0xffffffff)
    for reader, writer in entities:
        pair = reader + writer
        payload = b"\0\1\0\0" + bytes(64)
        yield submessage(ACKNACK, pair + numbers + b"\1\0\0\0")
        yield submessage(HEARTBEAT, pair + number(1) + number(9) + b"\1\0\0\0")
        yield submessage(GAP, pair + number(1) + numbers)
        yield submessage(NACK_FRAG, pair + number(1) + struct.pack("<IIII", 1, 32, 2**32 - 1, 1))
        yield submessage(HEARTBEAT_FRAG, pair + number(1) + struct.pack("<II", 4, 1))
        yield submessage(DATA, b"\0\0\x10\0" + pair + number(1) + payload, 5)
        fragment = struct.pack("<IHHI", 1, 1, 64, 128)
        yield submessage(DATA_FRAG, b"\0\0\x1c\0" + pair + number(2) + fragment + payload)


class Stranger:
    """The participant that does not exist, and what the node tells it."""

    def __init__(self):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4_000_000)
        self.socket.bind(("127.0.0.1", STRANGER_PORT))
        self.socket.settimeout(0.5)
        self.heard = []

    def receive(self, wanted, time_s=10.0):
        end = time.monotonic() + time_s
        while time.monotonic() < end:
            try:
                packet = self.socket.recv(65_536)
            except TimeoutError:
                continue
            if packet[:4] == b"RTPS" and wanted(packet):
                return packet
        return None

    def meet(self):
        """Announces itself with the words of the node, and hears of its endpoints."""
        spdp = bytes.fromhex("000100c2")
        announcement = self.receive(lambda packet: spdp in packet and packet[8:10] == b"\1\x12")
        assert announcement, "the node does not announce itself"
        self.node = announcement[8:20]
        self.ports = [locator_port(announcement, kind) for kind in (METATRAFFIC, USER_TRAFFIC)]
        for port in self.ports:
            announcement = announcement.replace(struct.pack("<I", port),
                                                struct.pack("<I", STRANGER_PORT))
        self.keep(announcement)
        self.send(self.heard[0])
        for kind in (3, 4):
            reader, writer = bytes([0, 0, kind, 0xc7]), bytes([0, 0, kind, 0xc2])
            want = number(1) + struct.pack("<II", 32, 0xffffffff)
            ask = submessage(ACKNACK, reader + writer + want + b"\1\0\0\0")
            time.sleep(0.2)
            self.send(self.packet(ask))
        self.receive(lambda packet: packet[8:20] == self.node and self.keep(packet), 2.0)
        assert any(b"circle_states" in packet for packet in self.heard), "no endpoint was told"

    def keep(self, packet):
        """As the stranger would say it."""
        self.heard.append(packet.replace(self.node, STRANGER))

    def packet(self, *submessages):
        to_node = submessage(14, self.node)
        return b"RTPS\2\4\1\x12" + STRANGER + b"".join([to_node, *submessages])

    def go_on(self, first, count=20):
        """Announcements with new numbers, of which none is the next one: they are only noticed."""
        for sequence in range(first, first + count):
            for kind in (3, 4):
                pair = bytes([0, 0, kind, 0xc7]) + bytes([0, 0, kind, 0xc2])
                said = b"\0\0\x10\0" + pair + number(sequence) + b"\0\3\0\0"
                self.send(self.packet(submessage(DATA, said, 5)))
            time.sleep(0.002)

    def send(self, packet, ports=None):
        for port in ports or self.ports:
            self.socket.sendto(packet, ("127.0.0.1", port))


def is_fatal(packet):
    """Whether RustDDS 0.15.1 cannot take it: it lists every number that a HEARTBEAT or GAP speaks
    of, until the memory is full, and counts fragments in a NACK_FRAG down from 0 or up to any.
    """
    place = 20
    while place + 4 <= len(packet):
        kind, flags = packet[place:place + 2]
        order = "<" if flags & 1 else ">"
        length = struct.unpack_from(order + "H", packet, place + 2)[0]
        if place + 28 <= len(packet) and kind in (HEARTBEAT, GAP):
            numbers = struct.unpack_from(order + "iIiI", packet, place + 12)
            if numbers[0] or numbers[2] or max(numbers[1], numbers[3]) > 1_000_000:
                return True
        if place + 28 <= len(packet) and kind == NACK_FRAG:
            if not 0 < struct.unpack_from(order + "I", packet, place + 20)[0] < 1_000_000:
                return True
        # RTPS 2.5, 9.4.5.1.3: of length 0, PAD and INFO_TS are empty, all others reach to the end.
        place += 4 + length if length or kind in (PAD, INFO_TS) else len(packet)
    return False


def altered(chance, packet):
    """A packet with some of its bytes changed, often those of lengths and counts."""
    packet = bytearray(packet)
    for _ in range(chance.choice([1, 1, 2, 4])):
        place = chance.randrange(20, len(packet))
        what = chance.randrange(5)
        if what == 0:
            packet[place] ^= 1 << chance.randrange(8)
        elif what == 1:
            packet[place] = chance.choice([0, 1, 0x7f, 0x80, 0xff])
        elif what == 2:
            place -= place % 4
            value = chance.choice([0, 1, 2**31 - 1, 2**31, 2**32 - 1])
            packet[place:place + 4] = struct.pack("<I", value)
        elif what == 3:
            del packet[place:place + chance.randrange(1, 9)]
        else:
            packet[place:place] = chance.randbytes(chance.randrange(1, 9))
        if len(packet) <= 21:
            break
    return bytes(packet)


def packets(stranger):
    """All that is sent, in this order."""
    chance = random.Random(SEED)
    builtin = [(bytes([0, 0, k, 0xc7]), bytes([0, 0, k, 0xc2])) for k in (2, 3, 4)]
    user = [(b"\0\0\0\0", b"\0\0\0\3"), (b"\0\0\2\4", b"\0\0\0\3"), (b"\0\0\0\4", b"\0\0\1\3")]
    spoken = [stranger.packet(said) for said in
              told_by_the_stranger(stranger.node, [*builtin, *user])]
    spoken.append(stranger.packet(*told_by_the_stranger(stranger.node, builtin)))
    whole = [*stranger.heard, *spoken]
    for packet in [stranger.heard[0], *spoken]:
        for length in range(len(packet)):
            yield packet[:length]
    for _ in range(RANDOM):
        size = chance.choice([1, 19, 20, 24, 64, 1400])
        yield chance.choice([b"", b"RTPS", b"RTPS\2\4\1\x12" + STRANGER]) + chance.randbytes(size)
    for _ in range(ALTERED):
        packet = altered(chance, chance.choice(whole))
        if not is_fatal(packet):
            yield packet


def check_alive():
    stranger, sent = Stranger(), 0
    with Carom("resolver") as carom:
        stranger.meet()
        with Client() as client:
            client.connect()
            for sent, packet in enumerate(packets(stranger), 1):
                stranger.send(packet)
                if sent % 20 == 0:
                    # What overflows the node's socket tests nothing.
                    time.sleep(0.002)
                if sent % 500 == 0:
                    client.connect()
            client.connect()
        with Client() as late:
            # RustDDS 0.15.1 stops reading announcements at one that it cannot decode, and goes on
            # when another arrives: whoever comes late is heard once that many have.
            sequences = itertools.count(1_000_000, 20)
            late.connect(lambda: stranger.go_on(next(sequences)))
        code, _ = carom.stop()
    stranger.socket.close()
    print(f"{sent} datagrams to each of two ports: alive, serving, exit code {code}")
    assert code == 0, f"exit code {code}"


def check_fatal():
    """A datagram that ends a thread of RustDDS ends the node, which says so in one line."""
    stranger = Stranger()
    with Carom("resolver") as carom:
        carom.may_fail = True
        stranger.meet()
        no_fragment = number(1) + struct.pack("<IIII", 0, 1, 2**31, 1)
        pair = b"\0\0\3\xc7" + b"\0\0\3\xc2"
        stranger.send(stranger.packet(submessage(NACK_FRAG, pair + no_fragment)))
        wait_until(lambda: not carom.alive(), "the end of a node without DDS")
        assert carom.process.returncode == 1, f"exit code {carom.process.returncode}"
        said = carom.wait_for_line("carom: ", "RustDDS", "has failed")
        print(said)


def main():
    check_alive()
    check_fatal()


if __name__ == "__main__":
    main()
