"""What ROS costs through a ticking tree, beside bare rclpy in the same layout of processes.

    python benchmarks/ros_calls.py

The servers run in processes of their own; an action's publishes, three times a goal, the status of every goal that it
remembers, so one that remembers 5 s of goals is measured, and one that remembers 0.5 s. Bare calls are `call_async`
with one client on a node, one executor thread and an event; GRIP's are the leaves of components in a task that is run,
with its journal. Both are measured in turns, since what else the machine does changes more from minute to minute than
they differ. Some 90 s.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from grip_bt.ros.command import child_environment

DATA = Path(__file__).resolve().parents[1] / "tests" / "ros" / "data"
DOMAIN = 91
CALLS, GOALS, WARM, ROUNDS = 300, 100, 20, 4
COMPONENTS = {
    "ask": "interface: std_srvs/srv/Trigger\nserver: /work/counts\noutcomes: {done: success}\n",
    "act": "interface: trial_interfaces/action/Work\nserver: /work\noutcomes: {done: 'true'}\n"
    'fixed: {input: "0", seconds: 0.0}\n',
    "act_briefly": "interface: trial_interfaces/action/Work\nserver: /brief\noutcomes: {done: 'true'}\n"
    'fixed: {input: "0", seconds: 0.0}\n',
}
KEPT = {"/work": 5.0, "/brief": 0.5}
CALL = "service call"
RESULTS = {server: f"goal -> result, ended ones kept {kept} s" for server, kept in KEPT.items()}


def told(name: str, milliseconds: list[float]) -> None:
    low, high = np.percentile(milliseconds, (50, 95))
    print(f"{name:<90} median {low:6.2f} ms, 95 % {high:6.2f} ms ({len(milliseconds)} times)")


def start_server(overlay: Path, name: str = "/work") -> subprocess.Popen[bytes]:
    server = subprocess.Popen(
        [sys.executable, str(DATA / "action_server.py"), name, str(KEPT[name])],
        env=child_environment([overlay], DOMAIN),
        stdout=subprocess.PIPE,
    )
    assert server.stdout is not None
    server.stdout.readline()
    return server


def timed(work: Callable[[], None], times: int) -> list[float]:
    taken = []
    for _ in range(times + WARM):
        began = time.perf_counter()
        work()
        taken.append((time.perf_counter() - began) * 1e3)
    return taken[WARM:]


Taken = dict[str, list[float]]


@contextmanager
def spinning() -> Iterator[tuple[Any, Any]]:
    """Give a node of its own, and its executor, that a thread spins."""
    import rclpy
    from rclpy.context import Context
    from rclpy.executors import SingleThreadedExecutor

    context = Context()
    rclpy.init(context=context, domain_id=DOMAIN)
    node = rclpy.create_node("bare", context=context, enable_rosout=False, start_parameter_services=False)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    stop = threading.Event()

    def spin() -> None:
        while not stop.is_set():
            executor.spin_once(timeout_sec=0.5)

    thread = threading.Thread(target=spin)
    thread.start()
    try:
        yield node, executor
    finally:
        stop.set()
        executor.wake()
        thread.join()
        node.destroy_node()
        context.try_shutdown()


def bare_calls() -> list[float]:
    """Return the times of calls with rclpy alone [ms]."""
    from std_srvs.srv import Trigger

    with spinning() as (node, _):
        client = node.create_client(Trigger, "/work/counts")
        client.wait_for_service(10)

        def call() -> None:
            done = threading.Event()
            client.call_async(Trigger.Request()).add_done_callback(lambda _: done.set())
            done.wait(10)

        return timed(call, CALLS)


def bare_goals(server: str) -> list[float]:
    """Return the times of goals with rclpy alone, from sending to the result [ms]."""
    from rclpy.action import ActionClient
    from trial_interfaces.action import Work

    with spinning() as (node, executor):
        action = ActionClient(node, Work, server)
        action.wait_for_server(10)

        def goal() -> None:
            done = threading.Event()

            def accepted(future) -> None:
                future.result().get_result_async().add_done_callback(lambda _: done.set())

            def send() -> None:  # on the executor's thread: elsewhere, answers are lost
                action.send_goal_async(Work.Goal(input="0", seconds=0.0)).add_done_callback(accepted)

            executor.create_task(send)
            done.wait(10)

        try:
            return timed(goal, GOALS)
        finally:
            action.destroy()


def bare(taken: Taken) -> None:
    """Take the time of calls and goals with rclpy alone."""
    taken.setdefault(f"bare: {CALL}", []).extend(bare_calls())
    for server, what in RESULTS.items():
        taken.setdefault(f"bare: {what}", []).extend(bare_goals(server))


def in_trees(folder: Path, figures: Taken) -> None:
    """Take the same from a task that is run, and how long an answer waits for the tick that takes it."""
    from grip_bt.app.runs.execute import run
    from grip_bt.nodes.component import ComponentLeaf

    stamps: dict[str, list[float]] = {"began": [], "answered": [], "taken": []}
    start, finish = ComponentLeaf.start, ComponentLeaf.finish

    def timed_start(leaf):
        stamps["began"].append(time.perf_counter())
        operation = start(leaf)
        operation.add_done_callback(lambda: stamps["answered"].append(time.perf_counter()))
        return operation

    def timed_finish(leaf, result):
        stamps["taken"].append(time.perf_counter())
        return finish(leaf, result)

    ComponentLeaf.start, ComponentLeaf.finish = timed_start, timed_finish
    goals = [("act", RESULTS["/work"], GOALS), ("act_briefly", RESULTS["/brief"], GOALS)]
    for name, what, times in [("ask", CALL, CALLS), *goals]:
        for times_of in stamps.values():
            times_of.clear()
        task = folder / f"{name}.yaml"
        task.write_text(
            f"grip: 1\nname: {name}\nroot:\n  kind: repeat\n  times: {times + WARM}\n  child:\n"
            f"    call: {{node: component/{name}}}\n"
        )
        result = run(task)
        assert result.outcome == "success", result
        began, answered, taken = (np.array(stamps[k][WARM:]) * 1e3 for k in ("began", "answered", "taken"))
        figures.setdefault(f"tree: {what}", []).extend(taken - began)
        figures.setdefault(f"tree: {what}: from the answer to the tick that takes it", []).extend(taken - answered)
    ComponentLeaf.start, ComponentLeaf.finish = start, finish


def idle() -> None:
    """Fifty components that are connected and have nothing to do."""
    from rclpy.executors import SingleThreadedExecutor  # noqa: F401 - loaded before the time is taken

    from grip_bt.ros.client.bus import Bus

    script = (
        "import sys, rclpy\nfrom rclpy.node import Node\nfrom std_srvs.srv import Trigger\nrclpy.init()\n"
        "node = Node('many')\n"
        "for i in range(50): node.create_service(Trigger, f'/s{i}', lambda request, response: response)\n"
        "print('serving', flush=True)\nrclpy.spin(node)\n"
    )
    server = subprocess.Popen([sys.executable, "-c", script], env=child_environment((), DOMAIN), stdout=subprocess.PIPE)
    assert server.stdout is not None
    server.stdout.readline()
    with Bus("idle", domain_id=DOMAIN) as bus:
        clients = [bus.service("std_srvs/srv/Trigger", f"/s{i}") for i in range(50)]
        waits = [client.wait_ready(20) for client in clients]
        for wait in waits:
            wait.wait(20)
            wait.result()
        time.sleep(1.0)
        before, began = sum(os.times()[:2]), time.monotonic()
        time.sleep(8.0)
        used = (sum(os.times()[:2]) - before) / (time.monotonic() - began)
    server.kill()
    server.wait()
    print(f"{'50 components, connected and idle':<90} {used:.1%} of a core")


def lost(overlay: Path) -> None:
    """Servers that aren't ours and are killed with a goal under way."""
    from trial_interfaces.action import Work

    from grip_bt.ros.client.bus import Bus

    taken = []
    with Bus("watcher", domain_id=DOMAIN) as bus:
        client = bus.action(Work, "/work")
        for _ in range(6):
            server = start_server(overlay)
            client.wait_ready(10).wait(10)
            operation = client.send(Work.Goal(input="0", seconds=60.0), wait=10.0)
            time.sleep(0.5)
            server.kill()
            began = time.perf_counter()
            operation.wait(30)
            taken.append((time.perf_counter() - began) * 1e3)
            server.wait()
    told("killed server, not ours, noticed", taken)


def main() -> None:
    from grip_bt.cli.component import generate
    from grip_bt.ros.interfaces import build_interfaces
    from grip_bt.ros.interfaces.packages import activate

    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    os.environ["ROS_DOMAIN_ID"] = str(DOMAIN)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "grip.yaml").write_text("grip: 1\n")
        (built,) = build_interfaces(DATA / "trial_interfaces", folder / ".grip" / "interfaces")
        activate(built.prefix)
        for component, text in COMPONENTS.items():
            home = folder / "components" / component
            home.mkdir(parents=True)
            (home / "component.yaml").write_text(f"name: {component}\n{text}")
            if "trial" in text:
                shutil.copytree(DATA / "trial_interfaces", home / "interfaces" / "trial_interfaces")
            generate([home])
        figures: Taken = {}
        with ExitStack() as servers:
            for server in [start_server(built.prefix, name) for name in KEPT]:
                servers.callback(server.wait)
                servers.callback(server.kill)
            for _ in range(ROUNDS):
                bare(figures)
                in_trees(folder, figures)
        for what, milliseconds in figures.items():
            told(what, milliseconds)
        for what in (CALL, *RESULTS.values()):
            ours, plain = np.median(figures[f"tree: {what}"]), np.median(figures[f"bare: {what}"])
            print(f"{what}: {ours / plain:.2f} of the bare one in the median, {ours - plain:+.2f} ms")
        idle()
        lost(built.prefix)
    print(f"load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
