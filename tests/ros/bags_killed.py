"""A node that is killed while it records: what was written up to the last chunk can be read.

And what the commands about bags say where they are asked for something that cannot be.
"""

import signal
import subprocess
import tempfile
from collections import Counter
from pathlib import Path

from harness import BINARY, Carom, Client, seconds, wait_until
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader
from mcap_ros2.decoder import DecoderFactory


def run(*arguments):
    return subprocess.run([BINARY, *arguments], capture_output=True, text=True, timeout=60)


def read_to_the_end(file):
    """Counts of what another reader finds before the file ends."""
    found = Counter()
    with file.open("rb") as stream:
        reader = NonSeekingReader(stream, decoder_factories=[DecoderFactory()], validate_crcs=True)
        try:
            for _, channel, _, _ in reader.iter_decoded_messages(log_time_order=False):
                found[channel.topic] += 1
        except EndOfFile:
            pass
    return found


def main():
    with tempfile.TemporaryDirectory() as name:
        bag = Path(name, "bag")
        with Client(topics=["arena_states"]) as client:
            states = client.inboxes["arena_states"].messages
            with Carom("teams", "--record", bag) as carom:
                wait_until(lambda: states and seconds(states[-1].header.stamp) > 4.0, "4 s")
                killed_at = seconds(states[-1].header.stamp)
                carom.process.send_signal(signal.SIGKILL)
                carom.process.wait(5.0)
        assert not (bag / "metadata.yaml").exists()
        found = read_to_the_end(bag / "bag_0.mcap")
        assert found["/arena_states"] >= 60 * (killed_at - 1.5), f"{found}, killed at {killed_at} s"
        again = run("run", "--verify", "--from", bag)
        assert again.returncode == 0 and "every bit agrees" in again.stdout, again
        for what in ("metadata.yaml: is missing", "was not closed", "ends too early"):
            assert what in again.stdout, f"{what}: {again.stdout}"
        reached = float(again.stdout.rsplit("up to ", 1)[1].split(" s")[0])
        assert reached > killed_at - 1.5, f"{reached} s of {killed_at} s"
        damaged = bytearray((bag / "bag_0.mcap").read_bytes())
        damaged[len(damaged) // 2] ^= 1
        broken = Path(name, "broken.mcap")
        broken.write_bytes(damaged)
        again = run("run", "--verify", "--from", broken)
        assert again.returncode == 1 and "damaged at" in again.stdout, again
        assert broken.read_bytes() == damaged, "the input was changed"
        for arguments, what in (
                (("replay", Path(name, "nothing")), "cannot be read"),
                (("replay", __file__), "is no recording"),
                (("record",), "TOPICS"),
                (("record", "a b"), "is not a ROS name"),
                (("record", "/clock", "-o", name), "is there already"),
                (("run", "teams", "--record", name), "is there already"),
                (("run", "--out", "x"), "--from")):
            refused = run(*map(str, arguments))
            line = refused.stderr.strip().splitlines()
            assert refused.returncode == 2 and what in line[-1], f"{arguments}: {refused}"
        print(f"killed at {killed_at:.2f} s, repeated up to {reached:.2f} s: {dict(found)}")


if __name__ == "__main__":
    main()
