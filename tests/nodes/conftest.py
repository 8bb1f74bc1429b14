"""A small world of fakes whose operations end when the test says so."""

from __future__ import annotations

from collections import defaultdict, deque
from types import SimpleNamespace

import numpy as np
import pytest
from py_trees.common import Status

from grip_bt.base.errors import DataError, UnknownNameError
from grip_bt.base.failures import CanceledError, NoGraspError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Grasp, JointState, Plan, Pose, Trajectory
from grip_bt.commanders.scene import PlanningScene
from grip_bt.task.catalog import Catalog
from grip_bt.task.catalog.catalog import load_implementation
from grip_bt.task.catalog.manifest import Manifest

AWAY = Pose([0.3, 0.0, 0.6])


def side_pose(centre, approach, radius=0.03, height=0.09):
    """Return the grasp frame beside an upright thing: z along `approach` (an angle), y up."""
    z = np.array([np.cos(approach), np.sin(approach), 0.0])
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([np.cross([0, 0, 1.0], z), [0, 0, 1.0], z], axis=1)
    matrix[:3, 3] = np.array([*centre, height]) - (radius + 0.004) * z
    return Pose.from_matrix(matrix)


def side_grasp(centre=(0.5, 0.1), approach=0.0, radius=0.03, height=0.09, **more):
    pose = side_pose(centre, approach, radius, height)
    z = pose.rotation()[:, 2]
    return Grasp(pose, pose.moved(-0.12 * z), pose.moved([0, 0, 0.15]), width=2 * radius, **more)


class Steps:
    """Gives out operations: ended at once, ended with a queued error, or held until `finish`."""

    def __init__(self):
        self.log = []
        self.errors = defaultdict(deque)
        self.held = set()
        self.pending = []

    def operation(self, verb, argument, result):
        self.log.append((verb, argument))
        if self.errors[verb]:
            error = self.errors[verb].popleft()
            if error is not None:
                return Operation.failed(error)
        if verb not in self.held:
            return Operation.finished(result())
        operation = Operation(on_cancel=lambda: self.log.append(("cancel", verb)))
        self.pending.append((operation, result))
        return operation

    def finish(self):
        operation, result = self.pending.pop(0)
        operation.succeed(result())

    def end_canceled(self):
        self.pending.pop(0)[0].fail(CanceledError("canceled"))

    def verbs(self):
        return [verb for verb, _ in self.log]


class FakeArm(Steps):
    name = "right"

    def __init__(self):
        super().__init__()
        self.pose = AWAY
        self.on_plan = lambda verb, goal: None
        self.feasible = lambda grasp: True

    def state(self):
        return JointState(("j",), [float(self.pose.position[0])])

    def grasp_pose(self):
        return self.pose

    def named_states(self):
        return {"home": JointState(("j",), [0.0])}

    def plan(self, goal, *, start=None, free="none", constraint=None):
        self.constraint = constraint
        return self._plan("plan", goal)

    def plan_from_trajectory(self, trajectory, *, slow_down=False):
        return self._plan("along", trajectory.end())

    def check_together(self, plans):
        return Operation.finished(None)

    def plan_straight(self, goals, *, start=None):
        return self._plan("straight", list(goals))

    def _plan(self, verb, goal):
        self.on_plan(verb, goal)
        return self.operation(verb, goal, lambda: self._as_plan(goal))

    def _as_plan(self, goal):
        plan = Plan("arm", Trajectory(("j",), [0.0], [[0.0]]))
        self.goal = goal
        return plan

    def execute(self, plan):
        goal = self.goal

        def arrive():
            last = goal[-1] if isinstance(goal, list) else goal
            if isinstance(last, Pose):
                self.pose = last
            return self.state()

        return self.operation("execute", goal, arrive)

    def choose_grasp(self, grasps):
        free = [g for g in sorted(grasps, key=lambda g: -g.quality) if self.feasible(g)]
        if not free:
            return Operation.failed(NoGraspError("none is feasible", reasons={"no_ik": len(grasps)}))
        return self.operation("choose", grasps, lambda: free[0])

    def stop(self):
        self.log.append(("stop", None))


class FakeHand(Steps):
    name = "right_hand"

    def __init__(self):
        super().__init__()
        self.touched, self.closed, self.at = {"finger": 5.0}, None, 0.0

    def contacts(self):
        return self.touched

    def closing(self):
        return self.closed

    def named_states(self):
        return {"open": JointState(("f",), [0.0]), "closed": JointState(("f",), [1.0])}

    def state(self):
        return JointState(("f",), [self.at])

    def open(self, posture="open"):
        return self.operation("open", posture, self.state)

    def close(self, posture="closed", torque_limit=None, force=None):
        return self.operation("close", (posture, torque_limit), self.state)

    def stop(self):
        self.log.append(("stop", None))


class FakeContext:
    """Workers run at once, unless `defer` is set; then `work()` runs them."""

    def __init__(self, arm, hand, scene):
        self._arm, self._hand, self._scene = arm, hand, scene
        self.cameras, self.components = {}, {}
        self.preempt_requested = False
        self.time, self.wakes, self.alarms = 100.0, 0, []
        self.defer, self.jobs = False, []
        self.clock = SimpleNamespace(now=lambda: self.time)

    def left(self, path, work):
        """Nothing here takes its time to stop."""

    def unfinished(self):
        return ()

    def wake(self):
        self.wakes += 1

    def wake_at(self, time):
        self.alarms.append(time)

    def run_in_worker(self, work):
        operation = Operation()

        def run():
            try:
                operation.succeed(work())
            except Exception as error:  # noqa: BLE001
                operation.fail(error)

        if self.defer:
            self.jobs.append(run)
        else:
            run()
        return operation

    def work(self):
        self.jobs.pop(0)()

    def arm(self, name):
        return self._look_up("arm", name, {"right": self._arm})

    def hand(self, name):
        return self._look_up("hand", name, {"right_hand": self._hand})

    def camera(self, name):
        return self._look_up("camera", name, self.cameras)

    def component(self, name):
        return self._look_up("component", name, self.components)

    def scene(self):
        return self._scene

    @staticmethod
    def _look_up(kind, name, known):
        if not name and len(known) == 1:
            return next(iter(known.values()))
        if name not in known:
            raise UnknownNameError(kind, name, known)
        return known[name]


class World:
    """The fakes, and leaves made from their manifests."""

    def __init__(self):
        self.arm, self.hand = FakeArm(), FakeHand()
        table = {"table": ([0.7, 1.2, 0.1], Pose([0.65, 0.0, -0.05]))}
        self.scene = PlanningScene({"right_hand": lambda: self.arm.grasp_pose()}, {**table, **crate()})
        self.context = FakeContext(self.arm, self.hand, self.scene)
        self.catalog = Catalog.builtin()
        self.data = {}

    def leaf(self, node, *, unbound=(), **values):
        """Make a leaf; `values` are its parameters and the values of its inputs. All outputs are bound."""
        manifest = node if isinstance(node, Manifest) else self.catalog.get(node)
        unknown = set(values) - set(manifest.parameters) - set(manifest.inputs)
        assert not unknown, f"{manifest.id} has no {unknown}"
        params = {n: values.get(n, p.default) for n, p in manifest.parameters.items()}
        leaf = load_implementation(manifest)("leaf", "task/leaf", manifest, params, {})
        for port in manifest.inputs:
            if port in values:
                leaf.readers[port] = self._reader(values[port])
        for port in manifest.outputs:
            if port not in unbound:
                leaf.writers[port] = lambda value, port=port: self.data.__setitem__(port, value)
        leaf.setup(context=self.context)
        return leaf

    @staticmethod
    def _reader(value):
        def read():
            if value is UNWRITTEN:
                raise DataError("task/leaf", "port", "wasn't written")
            return value

        return read

    def stand(self, name="seen_0", centre=(0.5, 0.1), radius=0.03, height=0.16):
        self.scene.set_box(
            name, [2 * radius, 2 * radius, height - 0.003], Pose([*centre, (height - 0.003) / 2 + 0.003])
        )

    def hold(self, height=0.16, radius=0.03):
        """Put an object into the hand, as `arm/lift` leaves it: 15 cm up."""
        self.stand(radius=radius, height=height)
        grasp = side_grasp(radius=radius)
        self.arm.pose = grasp.pose
        lift = self.leaf("arm/lift", grasp=grasp)
        lift.tick_once()
        assert lift.status == Status.SUCCESS
        self.arm.log.clear()


UNWRITTEN = object()


def crate(centre=(0.48, -0.40), inner=(0.26, 0.30), height=0.06, wall=0.01):
    (cx, cy), (ix, iy) = centre, inner
    dx, dy = (ix + wall) / 2, (iy + wall) / 2
    along_x, along_y = [ix + 2 * wall, wall, height], [wall, iy, height]
    return {
        "crate_left": (along_x, Pose([cx, cy + dy, height / 2])),
        "crate_right": (along_x, Pose([cx, cy - dy, height / 2])),
        "crate_far": (along_y, Pose([cx + dx, cy, height / 2])),
        "crate_near": (along_y, Pose([cx - dx, cy, height / 2])),
    }


@pytest.fixture
def world():
    return World()


@pytest.fixture
def grasp_at():
    return side_grasp


@pytest.fixture
def tick():
    """Tick a leaf once and return (status, outcome, failure code)."""

    def once(leaf):
        leaf.tick_once()
        return leaf.status.name, leaf.outcome, leaf.code

    return once
