"""What the scripts of the wire share: the node as a child process, and sockets of a team.

Messages are read by protobuf's own classes, generated from the definitions beside this file. All
traffic stays on loopback. Only children started here are ever ended; no wait is a fixed time.
"""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

BINARY = os.environ["CAROM_BIN"]
HOST = "127.0.0.1"
TIMEOUT_S = 15.0

# A script that is asked to end must still end its node on the way out.
signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by SIGTERM"))


def free_ports(count):
    """Ports that nobody has now."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    for each in sockets:
        each.bind((HOST, 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class Carom:
    """The node as a child process: `with Carom("ssl-b", "--wire") as carom:`."""

    def __init__(self, *arguments):
        self.lines = []
        self.process = subprocess.Popen(
            [BINARY, "run", *map(str, arguments)],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stderr:
            self.lines.append(line.rstrip("\n"))

    def alive(self):
        return self.process.poll() is None

    def memory_bytes(self):
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        line = next(line for line in status.splitlines() if line.startswith("VmRSS"))
        return 1024 * int(line.split()[1])

    def stop(self):
        """Ends the node by Ctrl-C: (exit code, seconds that it took)."""
        start = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(TIMEOUT_S)
        self._reader.join(5.0)
        return code, time.monotonic() - start

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if self.alive():
            self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(5.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._reader.join(5.0)
        panicked = any("panicked" in line or "has failed" in line for line in self.lines)
        if kind or panicked:
            print("--- log of the node", *self.lines, "---", sep="\n", file=sys.stderr)
        assert kind or not panicked, "the node panicked"


class Listener:
    """Where packets arrive: each is kept as its message, with the time of its arrival."""

    def __init__(self, kind, group=None):
        self.kind = kind
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self.socket.bind((group or HOST, 0))
        if group:
            member = socket.inet_aton(group) + socket.inet_aton(HOST)
            self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
        self.socket.settimeout(TIMEOUT_S)
        self.address = f"{group or HOST}:{self.socket.getsockname()[1]}"

    def next(self):
        """The next packet, waited for."""
        message = self.kind()
        message.ParseFromString(self.socket.recv(65536))
        return message

    def drain(self):
        """What has arrived already, thrown away."""
        self.socket.settimeout(0.0)
        try:
            while True:
                self.socket.recv(65536)
        except BlockingIOError:
            pass
        finally:
            self.socket.settimeout(TIMEOUT_S)

    def until(self, condition, what, each=None, timeout_s=TIMEOUT_S):
        """The first packet from now on of which this holds; `each` is called before each."""
        self.drain()
        deadline = time.monotonic() + timeout_s
        while time.monotonic() < deadline:
            if each:
                each()
            message = self.next()
            if condition(message):
                return message
        raise AssertionError(f"{what}: not within {timeout_s} s; last: {message}")


class Asker:
    """One end of a port of the node: asks, and reads the answer."""

    def __init__(self, port, answer):
        self.to, self.answer = (HOST, port), answer
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((HOST, 0))
        self.socket.settimeout(TIMEOUT_S)

    def send(self, datagram):
        self.socket.sendto(datagram, self.to)

    def ask(self, message):
        """The answer to a message, or to bytes."""
        self.send(message if isinstance(message, bytes) else message.SerializeToString())
        answer = self.answer()
        answer.ParseFromString(self.socket.recv(65536))
        return answer

    def codes(self, message):
        """The codes of the errors in the answer."""
        return [error.code for error in self.ask(message).errors]


def assert_close(actual, expected, tolerance, what):
    assert abs(actual - expected) <= tolerance, f"{what}: {actual!r}, expected {expected!r}"
