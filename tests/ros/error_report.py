"""The live report: once a second, sane, the same in /diagnostics, and with what went wrong."""

import math
import time
from math import nan

from carom.msg import ErrorReport
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Twist
from harness import QOS, Carom, Circle, Client, scene, seconds, wait_until

CAUSES = ["undecodable", "too_many_circles", "not_finite", "out_of_range", "duplicate_id",
          "wall_id", "simulated_id", "too_many_observed", "too_wide", "not_met", "too_many_pairs",
          "unknown_robot"]
FACTS = {"method", "left_out"}
# A second of it takes many seconds: a thousand pucks at speeds of a thousand radii a second.
HARD = """\
name: more than any machine does in real time
walls: {x: [0.0, 5.0], y: [0.0, 5.0]}
batches:
  - {name: fast, count: 1000, seed: 1, radius: 0.0488, speed: 20000.0}
"""


class Reports:
    """Reports and diagnostics as they come, each with the time at which it came."""

    def __init__(self, client):
        self.reports, self.statuses, self.heard_at = [], [], []
        client.node.create_subscription(ErrorReport, "error_report", self._report, QOS)
        client.node.create_subscription(DiagnosticArray, "/diagnostics", self._status, QOS)

    def _report(self, message):
        self.heard_at.append(time.monotonic())
        self.reports.append(message)

    def _status(self, message):
        assert len(message.status) == 1, f"{len(message.status)} statuses"
        self.statuses.append(message)

    def wait_for(self, count):
        wait_until(lambda: min(len(self.reports), len(self.statuses)) >= count,
                   f"{count} reports", timeout_s=30.0)


def values(message):
    return {pair.key: pair.value for pair in message.status[0].values}


def check_same(report, status):
    """Every number of a report stands in the diagnostics of the same second, to all digits."""
    found = values(status)
    counts = dict(zip(report.refused_causes, report.refused_counts))
    assert list(counts) == CAUSES, f"{report.refused_causes}"
    for cause, count in counts.items():
        assert int(found[f"refused.{cause}"]) == count, f"{cause}: {found}"
    names = set(report.get_fields_and_field_types()) - {"header", "refused_causes",
                                                        "refused_counts"} - FACTS
    for name in names:
        expected, actual = getattr(report, name), float(found[name])
        same = actual == expected or math.isnan(actual) and math.isnan(expected)
        assert same, f"{name}: {found[name]} in /diagnostics, {expected!r} in error_report"
    assert found["method"] == report.method
    assert found["left_out"] == ", ".join(report.left_out)
    assert status.status[0].hardware_id == "carom"


def pairs(reports):
    """Reports and diagnostics of the same second; the first of either may have been missed."""
    by_mean = {float(values(status)["step_mean_s"]): status for status in reports.statuses}
    both = [(r, by_mean[r.step_mean_s]) for r in reports.reports if r.step_mean_s in by_mean]
    assert len(both) >= len(reports.reports) - 1, "reports without diagnostics"
    for report, status in both:
        check_same(report, status)
    return both


def check_sane(report):
    assert report.method == "events", report.method
    assert report.header.frame_id == "map"
    assert 30 <= report.steps <= 1000, f"{report.steps} steps in a second"
    assert 0 < report.step_mean_s <= report.step_max_s < 1, f"{report}"
    assert 0 < report.step_p99_s <= report.step_max_s, f"{report}"
    assert 5 < report.contacts_per_second < 500, f"{report.contacts_per_second} contacts/s"
    assert report.real_time_factor_asked == 1.0
    assert report.energy > 1, f"{report.energy} J"
    # Momenta of some kg m/s, energies of some J: rounding and no more.
    assert abs(report.relative_energy_drift) < 1e-14, f"{report.relative_energy_drift}"
    assert 0 <= report.momentum_drift < 1e-13, f"{report.momentum_drift}"
    assert 0 <= report.largest_overlap < 1e-12, f"{report.largest_overlap} m"
    assert "gravity" in report.left_out and "walls" not in report.left_out, f"{report.left_out}"
    assert "momentum account" not in report.left_out, f"{report.left_out}"


def check_driven():
    """Once a second, and work by commands is no error."""
    with Carom("arena") as carom, Client(topics=[]) as client:
        reports = Reports(client)
        driver = client.node.create_publisher(Twist, "pucks/alice/cmd_vel", 10)
        twist = Twist()
        wait_until(lambda: driver.get_subscription_count() > 0, "a reader of cmd_vel")
        reports.wait_for(1)
        energy = reports.reports[0].energy

        def drive():
            twist.linear.x = 1.5 if twist.linear.x <= 0 else -1.5
            driver.publish(twist)

        wait_until(lambda: len(reports.reports) >= 6, "six reports", timeout_s=30.0, each=drive,
                   period_s=0.05)
        assert carom.alive()
    for report in reports.reports:
        check_sane(report)
    assert any(abs(r.energy - energy) > 0.5 for r in reports.reports), "commands did no work"
    times = reports.heard_at
    mean_s = (times[-1] - times[0]) / (len(times) - 1)
    assert 0.9 < mean_s < 1.3, f"a report every {mean_s} s"
    stamps = [seconds(report.header.stamp) for report in reports.reports]
    assert all(0.3 < b - a < 3 for a, b in zip(stamps, stamps[1:])), f"stamps {stamps}"
    both = pairs(reports)
    print(f"{len(times)} reports, one every {mean_s:.3f} s; {len(both)} as in /diagnostics; drift "
          f"{max(abs(r.relative_energy_drift) for r in reports.reports):.1e} and "
          f"{max(r.momentum_drift for r in reports.reports):.1e} kg m/s")


def check_refused():
    """Each cause is counted for itself, and the second in which it came warns."""
    bad = [Circle(1, nan, 0, 0, 0, 1, 1), Circle(2, 500, 0, 0, 0, 1, math.inf),
           Circle(3, 0, 9, 0, 0, -1, 1), Circle(4, 0, 0, 1e70, 0, 1, 1),
           Circle(5, 50, 0, 0, 0, 1, 1), Circle(5, 50, 0, 0, 0, 1, 1),
           Circle(4_294_967_295, 70, 0, 0, 0, 1, 1), Circle(1_000_000, 90, 0, 0, 0, 1, 1)]
    expected = {"not_finite": 1, "out_of_range": 2, "duplicate_id": 1, "wall_id": 1,
                "simulated_id": 1}
    with Carom("head_on") as carom, Client() as client:
        reports = Reports(client)
        reports.wait_for(2)
        client.connect()
        client.publish(bad)
        carom.wait_for_line("ERROR", "1000000")

        def counts(report):
            found = dict(zip(report.refused_causes, report.refused_counts))
            return {cause: count for cause, count in found.items() if count}

        wait_until(lambda: any(counts(r) == expected for r in reports.reports),
                   f"refusals {expected}, not {counts(reports.reports[-1])}")
        reports.wait_for(len(reports.reports) + 2)
    for report, status in pairs(reports):
        assert sum(counts(report).values()) in (0, 6), f"{counts(report)}"
    warned = [status.status[0] for _, status in pairs(reports)
              if "refused" in status.status[0].message]
    assert len(warned) == 1 and warned[0].level == DiagnosticStatus.WARN, f"{warned}"
    assert "6 inputs refused: not_finite, out_of_range, duplicate_id" in warned[0].message
    print(f"refused by cause: {expected}; said once: {warned[0].message}")


def check_impossible():
    """A real-time factor that no machine reaches is a warning every second."""
    with Carom(scene(HARD)), Client(topics=[]) as client:
        reports = Reports(client)
        reports.wait_for(3)
    for report, status in pairs(reports):
        assert report.real_time_factor < 0.9, f"{report.real_time_factor}"
        assert status.status[0].level == DiagnosticStatus.WARN, f"{status.status[0]}"
        assert "of 1 asked" in status.status[0].message, f"{status.status[0].message}"
        assert abs(report.relative_energy_drift) < 1e-13 and report.momentum_drift < 1e-6
    print(f"impossible: {status.status[0].message}")


def main():
    check_driven()
    check_refused()
    check_impossible()


if __name__ == "__main__":
    main()
