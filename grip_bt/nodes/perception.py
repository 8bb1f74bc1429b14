"""Leaves that take and compare images, take what sensors give, and decide whether a hand holds something."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial

import numpy as np

from grip_bt.base.failures import SensorError, ViewBlockedError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Camera, Context, Sensor
from grip_bt.base.steps import Steps
from grip_bt.base.types import Value
from grip_bt.base.values import Grasp, JointState, PointCloud, RgbdFrame
from grip_bt.nodes.arm import ArmLeaf, expect_state
from grip_bt.nodes.camera_views import Change, Thresholds, compare, outline, robot_pixels, share, within
from grip_bt.nodes.evidence import Evidence, EvidenceLimits, hand_evidence, holds, image_evidence, sight_evidence
from grip_bt.nodes.hand import HandLeaf
from grip_bt.nodes.leaf import OperationLeaf, Status
from grip_bt.nodes.motion import first_of, go


class Sense(OperationLeaf):
    """Take one value of each output of the sensor that the manifest's `settings` name."""

    sensor: Sensor

    def prepare(self) -> None:
        self.sensor = self.context.sensor(self.manifest.settings["sensor"])

    def start(self) -> Operation[Mapping[str, Value]]:
        return self.sensor.capture()

    def finish(self, result: Mapping[str, Value]) -> Status:
        if missing := [port for port in self.manifest.outputs if port not in result]:
            raise SensorError(f"the sensor gave nothing for {', '.join(missing)}; it gave {', '.join(result)}")
        return self.end(**{port: result[port] for port in self.manifest.outputs})


@dataclass(frozen=True, slots=True)
class _Look:
    """A frame, and what the robot hides of it: a share of the region, 0..1; `points` are None where nobody asks."""

    frame: RgbdFrame
    hidden: float
    points: PointCloud | None


class Capture(OperationLeaf):
    """Take one frame with the sensor that the manifest's `settings` name.

    What the robot hides is known from its joints and its description (`sight`). A frame of which it hides more than
    `max_hidden` is the failure `view_blocked`: nothing that isn't seen in it is known to be absent.
    """

    camera: Camera
    waits = True  # a frame that was taken while the arm still brakes shows neither before nor after

    def prepare(self) -> None:
        self.camera = self.context.camera(self.manifest.settings["sensor"])
        _check_region(self.path, self.params["region"])

    def start(self) -> Operation[_Look]:
        return self.camera.capture().then(lambda frame: self.context.run_in_worker(lambda: self._looked(frame)))

    def finish(self, result: _Look) -> Status:
        most = self.params["max_hidden"]
        if result.hidden > most:
            text = f"the robot hides {result.hidden:.0%} of the view; {most:.0%} at most may be hidden"
            return self.fail("view_blocked", text, outputs={"hidden": result.hidden}, hidden=result.hidden)
        points = {"points": result.points} if result.points is not None else {}
        return self.end(frame=result.frame, hidden=result.hidden, **points)

    def _looked(self, frame: RgbdFrame) -> _Look:
        depth, p = frame.depth, self.params
        robot = robot_pixels(depth, self.context.scene().robot())
        hidden = share(robot, within(depth.info, p["region"], p["table"]))
        if "points" not in self.writers:
            return _Look(frame, hidden, None)
        beside = replace(frame, depth=replace(depth, depth=np.where(robot, np.float32(0), depth.depth)))
        return _Look(frame, hidden, beside.cloud())


def _check_region(path: str, region: list[float]) -> None:
    """Raise ValueError unless a region is empty, or x from, x to, y from, y to."""
    if region and not (len(region) == 4 and region[0] < region[1] and region[2] < region[3]):
        raise ValueError(f"{path}: `region` is x from, x to, y from, y to [m], or empty, not {region}")


class ImageDifference(OperationLeaf):
    """Decide from a frame before and one after a pick whether the object has left its place.

    This is GRIP's image-difference check, with depth added: `compare` says how pixels are classified. The object
    counts as taken when enough of its pixels show the table now, and when not much has appeared elsewhere on the
    table: what was only pushed aside, or fell out of the hand, appears there. What left the camera's view altogether
    can't be told from what is held: `hand/holds` asks the hand too. Without a grasp, everything above the table is
    looked at.
    """

    def start(self) -> Operation[Change]:
        p = self.params
        limits = Thresholds(p["color_threshold"], p["depth_threshold"], p["table"], p["max_height"], p["radius"])
        return changed(self.context, self.read("before"), self.read("after"), self.read("grasp"), limits)

    def finish(self, result: Change) -> Status:
        p = self.params
        one = image_evidence(result, p["min_vacated"], p["max_appeared"], p["min_pixels"])
        if one.held is None:
            raise SensorError(one.why, object_pixels=result.object_pixels)
        outputs = {"fraction": result.vacated}
        return self.end(**outputs) if one.held else self.fail("not_held", one.why, outputs=outputs, **asdict(result))


def changed(
    context: Context, before: RgbdFrame, after: RgbdFrame, grasp: Grasp | None, limits: Thresholds
) -> Operation[Change]:
    """Compare frames from before and after a pick in a worker, around the grasp where there is one.

    Raises:
        SensorError: they aren't of one camera that stood still.
    """
    if before.depth.info != after.depth.info:
        raise SensorError("the two frames were not taken by one camera that stood still")
    place = None if grasp is None else grasp.closing_points()[0]
    return context.run_in_worker(lambda: compare(before, after, place, limits))


class Holds(HandLeaf):
    """Ask the hand's contacts and fingers, and a camera where frames are bound; see `evidence` for the rule.

    A frame after the pick lets the camera look for the object in the hand, and one before it besides lets it look
    whether the object's place is empty.
    """

    def start(self) -> Steps[list[Evidence]]:
        p = self.params
        evidence = hand_evidence(self.hand, EvidenceLimits(p["force"], p["links"], p["least_open"], p["most_moved"]))
        before, after, grasp = self.read("before"), self.read("after"), self.read("grasp")
        if after is not None:
            scene, hand = self.context.scene(), self.hand.name
            seen = lambda: sight_evidence(after.depth, scene, hand, scene.robot())  # noqa: E731 - in a worker
            evidence.append((yield self.context.run_in_worker(seen)))
        if after is not None and before is not None:
            change: Change = yield changed(self.context, before, after, grasp, Thresholds(table=p["table"]))
            evidence.append(image_evidence(change, p["min_vacated"], p["max_appeared"]))
        return evidence

    def finish(self, result: list[Evidence]) -> Status:
        evidence = {one.name: one.held for one in result}
        if holds(result):
            return self.end(evidence=evidence)
        against = [one for one in result if one.held is False]
        text = "; ".join(map(str, against)) or "nothing shows that the hand holds something"
        agree = [one.name for one in result if one.held]
        if against and agree:
            text += f"; against {' and '.join(agree)}"
        return self.fail("not_held", text, outputs={"evidence": evidence}, evidence={v.name: str(v) for v in result})


STEP = np.radians(15)
"""By how much the arm's first joint is turned from one candidate to the next."""


class ClearView(ArmLeaf):
    """Go to a named state or, where the robot would hide too much from there, to the nearest posture that hides less.

    Candidates are the arm's named states, and the first of them with the arm turned about its first joint: an arm that
    looks at a table from its side is out of the view when it looks elsewhere. What each would hide is known before
    anything moves, from the robot's hulls (`sight.outline`).
    """

    camera: Camera

    def prepare(self) -> None:
        super().prepare()
        self.camera = self.context.camera(self.params["sensor"])
        _check_region(self.path, self.params["region"])
        expect_state(self.arm, self.params["state"], self.path)

    def start(self) -> Steps[JointState]:
        try:
            self.camera.info()
        except SensorError:  # of a camera on topics nothing is known before its first frame
            yield self.camera.capture()
        clear = yield self.context.run_in_worker(self._clear)
        reached: JointState = yield first_of(partial(go, self.arm, state) for state in clear)
        return reached

    def _clear(self) -> list[JointState]:
        """Return the candidates that hide little enough: the named state, then the nearest to where the arm is."""
        p, info, now = self.params, self.camera.info(), self.arm.state()
        region, scene = within(info, p["region"], p["table"]), self.context.scene()
        wanted, *others = self._candidates()
        others.sort(key=lambda state: float(np.abs(state.position - now.ordered(state.names)).max()))
        least, clear = 1.0, []
        for state in (wanted, *others):
            hidden = share(outline(info, scene.robot(state)), region)
            least = min(least, hidden)
            if hidden <= p["max_hidden"]:
                clear.append(state)
                if state is wanted:
                    break
        if not clear:
            raise ViewBlockedError(
                f"wherever the arm goes, the robot hides {least:.0%} of the view; {p['max_hidden']:.0%} at most may be",
                hidden=least,
            )
        return clear

    def _candidates(self) -> Iterator[JointState]:
        states, joints = dict(self.arm.named_states()), self.arm.state().names
        wanted = states.pop(self.params["state"])
        yield wanted
        yield from (state for state in states.values() if set(state.names) == set(wanted.names))
        first = next((k for k, name in enumerate(wanted.names) if name == joints[0]), 0)
        for turn in np.arange(STEP, np.pi, STEP):
            for side in (1, -1):
                position = np.array(wanted.position)
                position[first] += side * turn
                yield JointState(wanted.names, position)
