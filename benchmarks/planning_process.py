"""The planning process: how long until it can plan, and how soon a request that is cancelled has ended.

    python benchmarks/planning_process.py [--robot NAME] [--times N]

Wall time. What is cancelled has no answer (for the Panda only). `by itself` counts the requests after which the process
went on; the others ended because it was replaced.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import time
from typing import Any

import numpy as np
from motion import spread
from plan_ways import queries

from grip_bt.base.failures import CanceledError, ExpectedError
from grip_bt.base.values import JointState, PathConstraint, Pose
from grip_bt.base.values.solids import Box
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.requests import PlanTo, Situation
from grip_bt.commanders.planning.service import PlanningProcess
from grip_bt.commanders.scene_state import SceneObject, SceneSnapshot
from grip_bt.commanders.settings import PLANNERS, PlanningSettings

ANYWHERE = PathConstraint(box=Pose(), size=(9.0, 9.0, 9.0))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="panda_allegro", choices=sorted(ROBOTS))
    parser.add_argument("--times", type=int, default=5)
    arguments = parser.parse_args()
    model = RobotModel(build_robot(arguments.robot))
    print(f"{arguments.robot}, load {os.getloadavg()[0]:.1f}")
    starts(model, arguments.times)
    if arguments.robot == "panda_allegro":
        noticed(model, arguments.times)
        cancels(model, arguments.times)
    print(f"load {os.getloadavg()[0]:.1f}")


def starts(model: RobotModel, times: int) -> None:
    """Print how long it takes from the start to the first answers, and to later ones."""
    took: dict[str, list[float]] = {}
    to_joints, again = queries(model, 2)
    assert isinstance(to_joints.goal, JointState)
    to_pose = dataclasses.replace(again, goal=model.grasp_pose(to_joints.goal))
    for _ in range(times):
        began = time.perf_counter()
        with PlanningProcess(model.description) as process:
            assert process.wait_until_ready()
            took.setdefault("ready after its start", []).append(time.perf_counter() - began)
            for name, request in (
                ("first plan to joints", to_joints),
                ("the same again", to_joints),
                ("first plan to a pose", to_pose),
                ("another to a pose", to_pose),
            ):
                asked = time.perf_counter()
                assert process.submit(request).wait(60)
                took.setdefault(name, []).append(time.perf_counter() - asked)
    for name, seconds in took.items():
        ms = np.array(seconds) * 1e3
        print(f"{name:28} median {np.median(ms):7.1f}, longest {ms.max():7.1f} ms")


def noticed(model: RobotModel, times: int) -> None:
    """Print, for each planner, CPU time from when it could know of a cancellation to its end.

    The cancellation comes at another time of the search each time: some have parts in which they ask nobody.
    """
    requests = {name: endless(model, planner=name) for name in PLANNERS}
    requests["CBiRRT (a path constraint)"] = endless(model, ANYWHERE)
    for name, request in requests.items():
        took = []
        for after in np.geomspace(0.1, 1.0, times):
            begin = time.thread_time() + after
            try:
                answer(model, request, lambda begin=begin: time.thread_time() > begin)  # type: ignore[misc]
            except CanceledError:
                took.append(time.thread_time() - begin)
            except ExpectedError as error:
                print(f"{name:28} ended by itself: {error.code}")
                break
        if took:
            print(f"{name:28} median {np.median(took) * 1e3:5.1f}, longest {max(took) * 1e3:5.1f} ms of CPU time")


def cancels(model: RobotModel, times: int) -> None:
    """Print, for each planner, how long a cancelled request took to end."""
    requests: dict[str, PlanTo] = {name: endless(model, planner=name) for name in PLANNERS}
    requests["CBiRRT (a path constraint)"] = endless(model, ANYWHERE)
    worst: list[float] = []
    with PlanningProcess(model.description) as process:
        for name, request in requests.items():
            took, stayed = [], 0
            for _ in range(times):
                assert process.wait_until_ready()
                pid, operation = process.pid, process.submit(request)
                if operation.wait(0.4):
                    print(f"{name:28} ended by itself: {_outcome(operation)}")
                    break
                asked = time.perf_counter()
                operation.cancel()
                assert operation.wait(60)
                took.append(time.perf_counter() - asked)
                time.sleep(0.1)  # a process that is replaced has another id by then
                stayed += process.pid == pid
            if took:
                ms = np.array(took) * 1e3
                print(
                    f"{name:28} median {np.median(ms):5.1f}, longest {ms.max():5.1f} ms; by itself {stayed} of {times}"
                )
            worst += took
    print({name: round(value, 1) for name, value in spread("cancelled", worst).items()})


def endless(model: RobotModel, constraint: PathConstraint | None = None, **settings: Any) -> PlanTo:
    """Return a request without an answer: the forearm is threaded through a frame that the hand doesn't fit through."""
    home, opened = (model.description.named_state(*state) for state in (("arm", "home"), ("hand", "open")))
    chain, snapshot = model.chain("arm", opened), SceneSnapshot()
    chain.grasp_pose(home.position)
    elbow, wrist = chain.data.oMi[4], chain.data.oMi[5]
    at = Pose.from_matrix(wrist.homogeneous)
    at = Pose(elbow.translation * 0.7 + wrist.translation * 0.3 + at.rotation()[:, 1] * 0.04, at.quaternion)
    for k, (x, y) in enumerate([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        size = (0.02, 0.22, 0.02) if x else (0.22, 0.02, 0.02)
        bar = Pose(at.apply([[0.1 * x, 0.1 * y, 0.0]])[0], at.quaternion)
        snapshot = snapshot.with_object(SceneObject(f"bar_{k}", Box(size), bar, fixed=True))
    checker = CollisionChecker(chain, snapshot, "hand")
    assert checker.free(home.position)
    rng, limits = np.random.default_rng(0), chain.limits
    turned = (q for _ in range(1000) if (q := rng.uniform(limits.lower, limits.upper))[0] > 1.0)
    goal = next(q for q in turned if checker.free(q))
    state = JointState(home.names + opened.names, np.concatenate([home.position, opened.position]))
    asked = PlanningSettings(seed=1, planning_time=60.0, **settings)
    begin = Situation("arm", state, snapshot, "hand", asked)
    return PlanTo(begin, JointState(chain.joints, goal), constraint=constraint)


def _outcome(operation: Any) -> str:
    try:
        return type(operation.result()).__name__
    except ExpectedError as error:
        return error.code


if __name__ == "__main__":
    main()
