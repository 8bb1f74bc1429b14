"""Figures of the ROS room: build, discovery, calls, conversion. `python benchmarks/ros_figures.py`; some 20 s."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from grip_bt.base.values import PointCloud
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.command import child_environment
from grip_bt.ros.convert import from_message, to_message
from grip_bt.ros.interfaces import build_interfaces

ROOT = Path(__file__).parents[1]
DOMAIN = 90
SERVER = ROOT / "tests" / "ros" / "data" / "servers.py"


def milliseconds(work: Callable[[], object], times: int) -> str:
    """Return the median and the 95th percentile of some runs of `work`."""
    taken = []
    for _ in range(times):
        started = time.perf_counter()
        work()
        taken.append((time.perf_counter() - started) * 1e3)
    return f"median {statistics.median(taken):7.2f} ms, 95 % {np.percentile(taken, 95):7.2f} ms ({times} times)"


def build() -> None:
    """An interface package of one service and one message."""
    with tempfile.TemporaryDirectory() as cache:
        (built,) = build_interfaces(ROOT / "examples/components/antipodal_grasps/interfaces", Path(cache))
        print(f"build of {built.package}: {built.seconds:.1f} s")


def calls() -> None:
    """A service in another process: found by a new bus, called one after another, and eight at a time."""
    from std_srvs.srv import SetBool

    server = subprocess.Popen(
        [sys.executable, str(SERVER), "std_srvs/SetBool", "/set"],
        env=child_environment(domain_id=DOMAIN),
        stdout=subprocess.PIPE,
    )
    assert server.stdout is not None
    server.stdout.readline()

    def discover() -> None:
        with Bus("discoverer", domain_id=DOMAIN) as bus:
            operation = bus.service(SetBool, "/set").wait_ready(10)
            operation.wait()
            operation.result()

    print(f"start of a bus until a running server is found: {milliseconds(discover, 20)}")
    with Bus("caller", domain_id=DOMAIN) as bus:
        client = bus.service(SetBool, "/set")

        def call() -> None:
            operation = client.call(SetBool.Request())
            operation.wait()
            operation.result()

        call()
        print(f"one call after another: {milliseconds(call, 1000)}")
        started = time.perf_counter()
        for operation in [client.call(SetBool.Request()) for _ in range(2000)]:
            operation.wait()
        print(f"many at once: {2000 / (time.perf_counter() - started):.0f} calls/s")
        held = client.call(SetBool.Request(data=True))
        time.sleep(0.2)
        server.kill()
        started = time.perf_counter()
        held.wait()
        print(f"a foreign server that was killed is noticed after {time.perf_counter() - started:.1f} s")
    server.wait()


def clouds() -> None:
    """A cloud of 300,000 points to its message and back."""
    from sensor_msgs.msg import PointCloud2

    rng = np.random.default_rng(0)
    points = rng.random((300_000, 3), np.float32)
    for words, cloud in (
        ("", PointCloud(points)),
        (" with colours", PointCloud(points, rng.integers(0, 255, (300_000, 3)))),
    ):
        message = to_message(cloud, PointCloud2)
        print(f"300,000 points{words} to a message: {milliseconds(lambda c=cloud: to_message(c, PointCloud2), 50)}")
        back = milliseconds(lambda m=message: from_message(m, "PointCloud"), 50)
        print(f"300,000 points{words} from a message: {back}")


if __name__ == "__main__":
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    build()
    calls()
    clouds()
