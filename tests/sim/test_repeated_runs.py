"""A seed gives the same run again, bit by bit, however late plans, workers and frames are ready."""

from __future__ import annotations

import random
import threading

import pytest
from same_run import compared

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.base.operation import Operation
from grip_bt.commanders.planning.service import PlanningProcess

pytestmark = pytest.mark.sim
PROJECT = """grip: 1
robot: panda_allegro
arms: {right: {group: arm, hand: right_hand}}
hands: {right_hand: {group: hand}}
sensors: {overhead: {camera: overhead}}
world: table
"""
NODES = '''
import asyncio
import random
import time

import grip_bt as grip
from grip_bt.base.values import Pose


@grip.leaf("own/think", outputs={"thought": float})
def think(context: grip.Context) -> float:
    """Think for a while of our own, in a worker, and say what the run's time is then."""
    time.sleep(random.SystemRandom().uniform(0.0, 0.1))
    return context.clock.now()


@grip.leaf("own/there_and_back", outputs={"at": Pose})
async def there_and_back(context: grip.Context, *, seconds: float = 0.2) -> Pose:
    """Move aside and back."""
    arm = context.arm("right")
    home = arm.grasp_pose()
    await asyncio.sleep(random.SystemRandom().uniform(0.0, 0.1))
    await arm.execute(await arm.plan(home.moved((0.0, 0.1, 0.0))))
    at = arm.grasp_pose()
    await arm.execute(await arm.plan(home))
    return at
'''
TASK = """grip: 1
name: side_by_side
data: {a: float, b: float, at: Pose, cloud: PointCloud, frame: RgbdFrame}
root:
  kind: sequence
  children:
    ready:
      kind: parallel
      children:
        release: {node: hand/open, with: {hand: right_hand}}
        home: {node: arm/move_to, with: {arm: right, state: home}}
        thoughts:
          kind: sequence
          children:
            one: {node: own/think, out: {thought: a}}
            rest: {node: flow/wait, with: {seconds: 0.21}}
            two: {node: own/think, out: {thought: b}}
            look: {node: sensor/overhead, out: {frame: frame, points: cloud}}
    aside:
      kind: parallel
      children:
        arm: {node: own/there_and_back, out: {at: at}}
        hand: {node: hand/open, with: {hand: right_hand}}
        obstacles: {node: scene/update_from_cloud, in: {cloud: cloud}}
"""


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_two_runs_of_a_seed_differ_in_no_event_value_kept_state_or_time(tmp_path, monkeypatch, target):
    submit, late = PlanningProcess.submit, random.SystemRandom()

    def submit_and_wait(self, request):
        planned = submit(self, request)
        operation = Operation(on_cancel=planned.cancel)

        def answer():
            try:
                operation.succeed(planned.result())
            except Exception as error:  # noqa: BLE001 - handed on
                operation.fail(error)

        planned.add_done_callback(lambda: threading.Timer(late.uniform(0.0, 0.2), answer).start())
        return operation

    monkeypatch.setattr(PlanningProcess, "submit", submit_and_wait)
    (tmp_path / "nodes").mkdir()
    (tmp_path / "nodes" / "own.py").write_text(NODES)
    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "task.yaml").write_text(TASK)
    journal, results, ids = tmp_path / "runs.sqlite", [], []
    for _ in range(2):
        with open_session(tmp_path / "task.yaml", RunOptions(target=target, seed=3, journal=journal)) as session:
            result = session.runner.run()
            results.append((result.status, result.failure, result.ticks, result.duration))
            ids.append(session.runner.run_id)
    assert results[0][:2] == ("success", None)
    assert results[0] == results[1]
    found = compared((journal, ids[0]), (journal, ids[1]))
    assert found.kept == 5
    assert found.written == 5
    assert found.differences == ()
