"""How long joints take to rest when they are told to stop, at random moments.

    stopping.py [--moments N] [--slow-moments N] [--seed S] [ROW...]

For every executor and every way of stopping: from the ask to the rest, less what braking at the joints' limits takes.
Executors with exact time are watched every 10 ms of it; what has the wall's time is measured by the stamps of joint
states, so a busy machine looks worse than it is. `plain` rows are told to stop by a client with rclpy alone, in its own
process; `kill -9` ends that client. A row is an executor's name, such as `fake` or `plain_served`; all by default.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

TESTS = Path(__file__).parents[1] / "tests"
sys.path[:0] = [str(TESTS / "contracts"), str(TESTS)]
SECONDS = 2.0
FAST = ("fake", "held", "joined")
CANCELED = 5


@dataclass
class Row:
    """What was measured of one executor and one way."""

    name: str
    way: str
    beyond: list[float] = field(default_factory=list)
    hardest: list[float] = field(default_factory=list)
    early: int = 0
    other: int = 0
    unconfirmed: int = 0

    def show(self, limit: float) -> str:
        late = sum(value > limit for value in self.beyond)
        worst, median = (1e3 * f(self.beyond) for f in (np.max, np.median)) if self.beyond else (np.nan, np.nan)
        hard = f"{max(self.hardest):.2f}" if self.hardest else "-"
        return (
            f"| {self.name} | {self.way} | {len(self.beyond)} | {median:.0f} | {worst:.0f} | {late} | {hard} |"
            f" {self.early} | {self.other} | {self.unconfirmed} |"
        )


COLUMNS = (
    "executor",
    "way",
    "moments",
    "beyond braking: median [ms]",
    "worst [ms]",
    "above 150 ms",
    "acceleration / limit",
    "ended before rest",
    "not CANCELED",
    "not confirmed",
)


def ours(
    name: str, table: dict[str, Callable[..., Any]], ways: list[str], servers: Servers, count: int, seed: int
) -> None:
    """Measure an executor of the contract's tables."""
    import inspect

    import conftest
    from stopping import BEYOND, go_elsewhere, smooth, stopped

    make, rng = table[name], np.random.default_rng(seed)
    needs = [servers.get(need) for need in inspect.signature(make).parameters]
    with make(*needs) as rig:
        for way in ways:
            row = Row(f"{name} (hand)" if table is conftest.HAND_PORTS else name, way)
            for moment in rng.uniform(0.0, 0.9, count) * SECONDS:
                if table is conftest.HAND_PORTS:
                    moment *= 0.4
                    made = stopped(rig, lambda: rig.port.move(rig.closed, 1.0), moment, way)
                    rig.wait(rig.port.move(rig.open, 1.0))
                else:
                    made = stopped(rig, lambda: rig.port.execute(smooth(rig, SECONDS)), moment, way)
                    go_elsewhere(rig)
                _note(row, made, rig.braking, rig.exact)
            print(row.show(BEYOND), flush=True)


def _note(row: Row, made: Any, limits: Any, exact: bool) -> None:
    row.beyond.append(made.beyond(limits))
    if exact:
        row.hardest.append(made.hardest(limits))
    if row.way == "pause":
        return
    row.other += made.error is None
    row.unconfirmed += made.error is not None and not made.error.data.get("stopped", True)
    after = made.positions[made.times >= made.ended] if made.ended is not None else made.positions[:0]
    row.early += len(after) > 1 and bool(np.ptp(after, axis=0).max() > 4e-3)


def simulated_physics(count: int) -> None:
    """Measure the simulator's own motions in exact simulated time, step by step: a cancel and a stop are one there."""
    from plain_client import swing
    from stopping import BEYOND, Stopped

    from grip_sim.motions import Follow
    from grip_sim.specs import WorldSpec
    from grip_sim.world import World

    world, rng, row = World(WorldSpec()), np.random.default_rng(5), Row("simulated (its physics)", "cancel, stop")
    robot = world.robot
    rows = robot.rows(robot.description.group("arm"))
    limits, home = robot.accelerations(rows), robot.positions()[rows]
    there = home + np.array([0.5, 0, 0.2, 0, 0, 0, 0.4])
    for moment in rng.uniform(0.0, 0.9, count) * SECONDS:
        here = robot.positions()[rows]
        goal = there if np.abs(here - home).max() < 0.25 else home
        times, positions, velocities = (np.array(c) for c in zip(*swing(here, goal, SECONDS), strict=True))
        motion: Any = Follow(robot, rows, times, positions, velocities, world.time)
        asked, seen, end = world.time + moment, [], None
        while end is None:
            if world.time >= asked and isinstance(motion, Follow):
                motion = motion.braking(world)
            end = motion.advance(world)
            if end is None:
                world.step()
                kept = robot.kept()
                seen.append((world.time, robot.positions()[rows], robot.velocities()[rows], kept["speeds"][rows]))
        ended, stayed = world.time, []
        while world.time < ended + 0.3:
            world.step()
            stayed.append(robot.positions()[rows])
        at, place, speed, target = (np.array(column) for column in zip(*seen, strict=True))
        row.beyond.append(Stopped(at, place, speed, asked).beyond(limits))
        row.hardest.append(Stopped(at, place, target, asked).hardest(limits))
        row.other += end.error != "canceled"
        row.unconfirmed += not end.stopped
        row.early += bool(np.ptp(np.array(stayed), axis=0).max() > 4e-3)
    print(row.show(BEYOND), flush=True)


@dataclass
class Wire:
    """A server that a plain client asks: its action, its type, its joints, how hard they brake, to and fro."""

    action: str
    kind: str
    names: tuple[str, ...]
    limits: Any
    away: Any
    domain: int
    overlays: list[Path]


def plain(name: str, wire: Wire, count: int, seed: int) -> None:
    """Measure a server that is asked by somebody else's program."""
    from plain_client import plain_client, swing
    from stopping import BEYOND, of_states

    from grip_bt.base.values import JointState

    rng = np.random.default_rng(seed + 4)
    with plain_client(wire.action, wire.kind, wire.names, wire.domain, wire.overlays) as client:
        home = client.now
        for way in ("cancel", "all"):
            row = Row(name, f"plain client, {'cancel' if way == 'cancel' else 'cancel all'}")
            for moment in rng.uniform(0.05, 0.85, count) * SECONDS:
                there = home + wire.away
                goal = there if np.abs(client.now - home).max() < np.abs(wire.away).max() / 2 else home
                after = float(moment) * (0.4 if wire.kind == "gripper" else 1.0)  # that one takes a second
                said = client.move(swing(client.now, goal, SECONDS), after, way)
                seen, last = [], -np.inf
                for _, stamp, position, velocity in said["samples"]:
                    if stamp > last:
                        last = stamp
                        seen.append(JointState(wire.names, position, velocity, time=stamp))
                made = of_states(seen, said["asked"], said["ended"], None)
                row.beyond.append(made.beyond(wire.limits))
                row.other += said["status"] != CANCELED
                after = made.positions[made.times >= said["ended"]]
                row.early += len(after) > 1 and bool(np.ptp(after, axis=0).max() > 4e-3)
            print(row.show(BEYOND), flush=True)


def killed(name: str, wire: Wire, states: Any, count: int) -> None:
    """Measure what becomes of a goal whose client is killed: how much of its way was left, and was still done."""
    from plain_client import plain_client, swing

    rng, goes_on = np.random.default_rng(12), 0
    for moment in rng.uniform(0.1, 0.7, count) * SECONDS:
        with plain_client(wire.action, wire.kind, wire.names, wire.domain, wire.overlays) as client:
            goal = client.now + wire.away * (-1 if client.now[0] > 0.25 else 1)
            client.begin(swing(client.now, goal, SECONDS), 10.0, "cancel")
            time.sleep(moment)
            client.process.kill()
        time.sleep(SECONDS)
        goes_on += bool(np.abs(states.state(wire.names).position - goal).max() < 0.05)
    print(f"| {name} | kill -9 of the client | {count} | {goes_on} went on to the goal's end |||||||", flush=True)


def simulation_killed(count: int) -> None:
    """Measure how long a simulator lives whose client is killed in the middle of a motion."""
    import subprocess

    program = """
import numpy as np, sys, time
from grip_bt.base.values import Trajectory
from grip_sim.simulation import start_simulation
from grip_sim.specs import WorldSpec
s = start_simulation(WorldSpec(), pace=1.0)
e = s.executor("arm"); h = e.state()
e.execute(Trajectory(h.names, np.array([0.0, 60.0]), np.stack([h.position, h.position + 0.5])))
print(s.pid, flush=True)
time.sleep(600)
"""
    lived = []
    for _ in range(count):
        child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
        assert child.stdout is not None
        pid = int(child.stdout.readline())
        time.sleep(float(np.random.default_rng(count).uniform(0.05, 0.5)))
        killed_at = time.monotonic()
        child.kill()
        while _alive(pid):
            time.sleep(0.002)
        lived.append(time.monotonic() - killed_at)
        child.wait()
        child.stdout.close()
    median, worst = 1e3 * np.median(lived), 1e3 * max(lived)
    print(
        f"| simulated | kill -9 of its client | {count} | world gone after {median:.0f} | {worst:.0f} ||||||",
        flush=True,
    )


def _alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


@contextlib.contextmanager
def served() -> Iterator[Wire]:
    """Run `grip sim`."""
    from simulated_robot import ARM, ARM_ACTION, simulated_robot

    from grip_bt.commanders.description.load import build_robot
    from grip_bt.ros.environment import free_domain
    from grip_bt.ros.interfaces.build import ensure_package

    limits = build_robot("panda_allegro").acceleration_limits
    away = np.array([0.5, 0, 0.2, 0, 0, 0, 0.4])
    with tempfile.TemporaryDirectory() as folder, free_domain() as domain:
        with simulated_robot(Path(folder), domain):
            braking = np.array([limits[name] for name in ARM])
            yield Wire(ARM_ACTION, "trajectory", ARM, braking, away, domain, list(ensure_package("control_msgs")))


class Servers:
    """The servers of the rows, each started when the first row needs it."""

    def __init__(self, stack: contextlib.ExitStack):
        self._stack, self._made = stack, dict[str, Any]()

    def get(self, name: str) -> Any:
        """Return the bus and the joint states of `ros_robot` or `ros_move_group`."""
        from ros_arm_rigs import move_group
        from ros_rigs import controllers

        if name not in self._made:
            make = {"ros_robot": controllers, "ros_move_group": move_group}[name]
            self._made[name] = self._stack.enter_context(make())
        return self._made[name]

    def wire(self, name: str) -> Wire:
        """Return how a plain client asks one of them."""
        from ros_arm_rigs import model
        from ros_rigs import NAMES, THEIRS

        from grip_bt.ros.interfaces.build import ensure_package

        if name == "plain_served":
            return self._stack.enter_context(served())
        moveit = name == "plain_move_group"
        bus, _ = self.get("ros_move_group" if moveit else "ros_robot")
        domain = bus.node.context.get_domain_id()
        overlays = list(ensure_package("moveit_msgs" if moveit else "control_msgs"))
        action, kind, names, away = {
            "plain_trajectory": ("/arm/follow_joint_trajectory", "trajectory", NAMES, (0.5, 0.4)),
            "plain_gripper": ("/claw/gripper_cmd", "gripper", ("claw",), (-1.0,)),
            "plain_move_group": (
                "/execute_trajectory",
                "moveit",
                tuple(model().description.group("arm")),
                (0.5, 0, 0.2, 0, 0, 0, 0.4),
            ),
        }[name]
        return Wire(action, kind, names, THEIRS, np.array(away), domain, overlays)


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--moments", type=int, default=200)
    parser.add_argument("--slow-moments", type=int, help="for rows whose time is the wall's; as --moments by default")
    parser.add_argument("--seed", type=int, default=7, help="of the moments")
    parser.add_argument("--kills", type=int, default=20, help="for the row `killed`")
    parser.add_argument("rows", nargs="*")
    asked = parser.parse_args()
    slow = asked.slow_moments or asked.moments
    import conftest

    import grip_bt.ros  # noqa: F401 - its settings come before any message package

    def wanted(name: str) -> bool:
        return not asked.rows or name in asked.rows

    print(f"load {os.getloadavg()[0]:.0f}\n\n| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|", flush=True)
    with contextlib.ExitStack() as stack:
        servers = Servers(stack)
        for name in filter(wanted, conftest.EXECUTORS):
            ways = ["cancel", "stop", *(["pause"] if name in conftest.PAUSABLE else [])]
            ours(name, conftest.EXECUTORS, ways, servers, asked.moments if name in FAST else slow, asked.seed)
        for name in (name for name in conftest.HAND_PORTS if wanted(f"hand_{name}")):
            ours(
                name,
                conftest.HAND_PORTS,
                ["cancel", "stop"],
                servers,
                asked.moments if name in FAST else slow,
                asked.seed,
            )
        if wanted("simulated_physics"):
            simulated_physics(asked.moments)
        for name in filter(wanted, ("plain_served", "plain_trajectory", "plain_gripper", "plain_move_group")):
            plain(name, servers.wire(name), slow, asked.seed)
        if wanted("killed"):
            killed("plain_trajectory", servers.wire("plain_trajectory"), servers.get("ros_robot")[1], asked.kills)
            simulation_killed(asked.kills)


if __name__ == "__main__":
    main()
