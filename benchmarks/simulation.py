"""What the simulated world costs: its start, a step while free and while grasping, a frame of the camera, a close.

    .venv/bin/python benchmarks/simulation.py

Wall time; steps and frames in this process, best of several rounds or of many frames; start and close of the process,
median. A step's ratio is that of CPU times, in short turns, to `bare` steps of the same scene: the forces that carry
the robot, and PhysX.
"""

import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Literal

import numpy as np

from grip_bt.base.values import Pose
from grip_sim.simulation import start_simulation
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec
from grip_sim.world import World
from grip_sim.worlds import load_world

ROUNDS, STEPS, STARTS, FRAMES = 5, 240, 5, 60
TURNS, TURN = 150, 24
"""Of steps of ours and bare ones, and steps of each; 24 are a multiple of those between two looks at contacts."""
AT = np.array([0.2319, 0.6334, -0.4097, -2.4792, 2.2391, 1.4242, -1.3702])
"""Arm positions at which the open hand surrounds what stands at `SPOT` [rad]."""
SPOT = Pose([0.55, 0.05, 0.09])
SHAPES: tuple[Literal["visual", "collision"], ...] = ("visual", "collision")
NEAR = CameraSpec("near", position=(0.45, 0.6, 0.5), target=(0.15, 0.25, 0.45), field_of_view=0.33)
BENCHMARK = Path(__file__).parents[1] / "examples" / "benchmark"


def per_second(world: World) -> float:
    """Return steps a second, the best round."""
    best = 0.0
    for _ in range(ROUNDS):
        began = time.perf_counter()
        for _ in range(STEPS):
            world.step()
        best = max(best, STEPS / (time.perf_counter() - began))
    return best


def grasping() -> World:
    """Return a world in which the hand presses a cylinder."""
    world = World(WorldSpec(objects=(ObjectSpec("thing", "cylinder", 0.03, 0.18, (0.9, 0.45, 0.09)),)))
    robot = world.robot
    robot.place(dict(zip(robot.description.group("arm"), AT, strict=True)))
    world.move_object("thing", SPOT)
    hand, closed = robot.description.group("hand"), robot.description.named_state("hand", "closed")
    rows = robot.rows(hand)
    robot.limit_torque(rows, 0.5)
    start, goal = robot.targets(rows), closed.ordered(hand)
    for part in np.linspace(0, 1, 2 * STEPS):
        robot.drive(rows, start + part * (goal - start))
        world.step()
    forces = world.hand_contacts("hand")
    assert len(forces) >= 3, f"the hand doesn't grasp: {forces}"
    return world


def ratio(world: World) -> str:
    """Return what a step takes, beside a bare one, and the ratio: the decile of many short turns."""

    def bare() -> None:
        world.robot.compensate()
        world.physics()

    turns = np.array([[_turn(world.step), _turn(bare)] for _ in range(TURNS)])
    ours, theirs = 1e6 * np.quantile(turns, 0.1, axis=0)
    return f"{ours:.0f} beside {theirs:.0f} us: {ours / theirs:.2f}"


def _turn(step: Callable[[], None]) -> float:
    """Return the CPU time of a step [s], behind one that isn't counted."""
    step()
    began = time.thread_time()
    for _ in range(TURN):
        step()
    return (time.thread_time() - began) / TURN


def pinched() -> World:
    """Return a world in which a gripper's regulated force holds a ball."""
    world = World(WorldSpec(robot="panda", objects=(ObjectSpec("thing", "sphere", 0.03, 0.06, (0.5, 0.0, 0.03)),)))
    robot = world.robot
    rows, tip = robot.rows(robot.description.group("hand")), robot.description.grasp_frame.link
    robot.press(rows, 15.0)
    for width in np.linspace(0.04, 0.0, STEPS):
        if not world.pressed("hand"):
            world.move_object("thing", world.link_pose(tip))
        robot.drive(rows, np.full(len(rows), width))
        world.step()
    assert world.pressed("hand"), "the gripper doesn't hold the ball"
    return world


def capture_time(world: World, camera: CameraSpec) -> str:
    """Return the time of a frame [ms], the least disturbed tenth, and how much of it the robot takes."""
    frame, times = world.cameras.view(camera), []
    for _ in range(FRAMES):
        began = time.perf_counter()
        world.cameras.view(camera)
        times.append(time.perf_counter() - began)
    robot = [number for number, name in enumerate(frame.names) if name.startswith(("panda", "hand"))]
    return f"{1e3 * np.quantile(times, 0.1):.1f} ms ({np.isin(frame.labels, robot).mean():.0%} of it the robot)"


def process_times() -> tuple[float, float]:
    """Return how long a process takes to come up, settled, and to be closed [s], medians."""
    starts, closes = [], []
    for _ in range(STARTS):
        began = time.perf_counter()
        simulation = start_simulation(load_world("table", 0))
        starts.append(time.perf_counter() - began)
        began = time.perf_counter()
        simulation.close()
        closes.append(time.perf_counter() - began)
    return statistics.median(starts), statistics.median(closes)


def main() -> None:
    """Measure and print the table."""
    free, holding = World(load_world("table", 0)), grasping()
    bench = World(replace(load_world("bench", 3, BENCHMARK), robot="panda"))
    for _ in range(STEPS):
        free.step()
        bench.step()
    start, close = process_times()
    print("| what | figure |\n|---|---|")
    print(f"| steps a second, free, {free.spec.dt * 1e3:.2f} ms each | {per_second(free):.0f} |")
    print(f"| steps a second, grasping | {per_second(holding):.0f} |")
    print(f"| one step, free | {ratio(free)} |")
    print(f"| one step, free, in the benchmark's world | {ratio(bench)} |")
    print(f"| one step, a hand grasping | {ratio(holding)} |")
    print(f"| one step, a gripper holding by a regulated force | {ratio(pinched())} |")
    for name, world, camera in (("from above", free, free.spec.cameras[0]), ("the arm from near", holding, NEAR)):
        for scale, shapes in product((1, 2), SHAPES):
            spec = replace(camera, width=320 * scale, height=240 * scale, shapes=shapes, renderer="raster")
            what = f"RGB-D frame {spec.width} x {spec.height}, {shapes} shapes, {name}"
            print(f"| {what} | {capture_time(world, spec)} |")
    print(f"| process up and settled | {start:.2f} s |")
    print(f"| process closed | {close:.3f} s |")


if __name__ == "__main__":
    main()
