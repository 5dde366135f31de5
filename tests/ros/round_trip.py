#!/usr/bin/env python3
"""Round trip of CircleStates -> CircleVelocities through two nodes, A and B, in the same run.

Messages to A and B alternate, half a period apart, so that machine noise hits both alike.
The circles touch and approach in pairs, so that a collision node has something to answer.
The answer is recognised by its stamp. Usage:
  ROS_DOMAIN_ID=60 round_trip.py [--a IN OUT] [--b IN OUT] [--circles 10] [--rate 100 1000] \
      [--seconds 10] [--pids A B] [--max-ratio 2.0]
With --pids the CPU time of both processes is told, as a share of one core.
Exit code 1 when A's median is more than max-ratio times B's, 2 when a node does not answer.
"""
import argparse
import sys
import time

import rclpy
from carom.msg import CircleState, CircleStates, CircleVelocities
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy

from harness import cpu_seconds

QOS = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)


def touching_pairs(count):
    """Pairs of circles in contact, approaching head-on; the pairs are far from each other."""
    circles = []
    for index in range(count):
        pair, second = divmod(index, 2)
        circles.append(CircleState(
            id=index, x=10.0 * pair + 0.19 * second, y=0.0,
            vx=-1.0 if second else 1.0, vy=0.0, radius=0.1, mass=1.0))
    return circles


class Path:
    """One way there and back: publishes to one topic, times the answers on another."""

    def __init__(self, node, name, topics, circles):
        self.name, self.sent, self.seconds, self.count = name, {}, [], 0
        self.message = CircleStates(circles=circles)
        self.message.header.frame_id = 'map'
        self.publisher = node.create_publisher(CircleStates, topics[0], QOS)
        self.subscription = node.create_subscription(
            CircleVelocities, topics[1], self.arrived, QOS)

    def arrived(self, answer):
        now = time.perf_counter()
        stamp = answer.header.stamp
        start = self.sent.pop((stamp.sec, stamp.nanosec), None)
        if start is not None:
            self.seconds.append(now - start)

    def send(self):
        self.count += 1
        # Unique stamps, so that late answers are not mistaken for others.
        key = divmod(time.time_ns(), 1_000_000_000)
        self.message.header.stamp.sec, self.message.header.stamp.nanosec = key
        self.sent[key] = time.perf_counter()
        self.publisher.publish(self.message)

    def clear(self):
        self.sent, self.seconds, self.count = {}, [], 0

    def percentile_us(self, share):
        ordered = sorted(self.seconds)
        return 1e6 * ordered[min(len(ordered) - 1, int(share * len(ordered)))]

    def ready(self):
        return self.publisher.get_subscription_count() and self.subscription.get_publisher_count()


def spin_to(executor, moment):
    while (left := moment - time.perf_counter()) > 0:
        executor.spin_once(timeout_sec=left)


def run(executor, paths, rate, seconds):
    period = 1.0 / (rate * len(paths))
    start = time.perf_counter()
    for index in range(int(seconds / period)):
        spin_to(executor, start + index * period)
        paths[index % len(paths)].send()
    elapsed = time.perf_counter() - start
    spin_to(executor, time.perf_counter() + 0.5)
    return elapsed


def report(paths, rate, elapsed):
    for path in paths:
        print(f'{rate:5d} Hz  {path.name}  p50 {path.percentile_us(0.5):7.0f} us  '
              f'p99 {path.percentile_us(0.99):7.0f} us  sent {path.count} '
              f'({path.count / elapsed:.0f} Hz)  lost {path.count - len(path.seconds)}')
    ratio = paths[0].percentile_us(0.5) / paths[-1].percentile_us(0.5)
    print(f'{rate:5d} Hz  ratio of medians A/B {ratio:.3f}', flush=True)
    return ratio


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('--a', nargs=2, default=['circle_states', 'corrected_velocities'])
    parser.add_argument('--b', nargs=2, default=['echo_in', 'echo_out'])
    parser.add_argument('--circles', type=int, default=10)
    parser.add_argument('--rate', type=int, nargs='+', default=[100, 1000])
    parser.add_argument('--seconds', type=float, default=10.0)
    parser.add_argument('--pids', type=int, nargs='*', default=[])
    parser.add_argument('--max-ratio', type=float, default=float('inf'))
    given = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node('round_trip')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    circles = touching_pairs(given.circles)
    paths = [Path(node, 'A', given.a, circles), Path(node, 'B', given.b, circles)]
    deadline = time.perf_counter() + 10
    while not all(path.ready() for path in paths) and time.perf_counter() < deadline:
        executor.spin_once(timeout_sec=0.05)
    ratios = []
    for rate in given.rate:
        run(executor, paths, rate, 1.0)  # warm-up
        for path in paths:
            path.clear()
        before = [cpu_seconds(pid) for pid in given.pids]
        elapsed = run(executor, paths, rate, given.seconds)
        shares = [(cpu_seconds(pid) - start) / elapsed for pid, start in zip(given.pids, before)]
        silent = [path.name for path in paths if not path.seconds]
        if silent:
            print('no answer from', *silent)
            sys.exit(2)
        ratios.append(report(paths, rate, elapsed))
        if shares:
            print(f'{rate:5d} Hz  CPU  A {shares[0]:.1%}  B {shares[1]:.1%} of a core', flush=True)
    sys.exit(max(ratios) > given.max_ratio)


main()
