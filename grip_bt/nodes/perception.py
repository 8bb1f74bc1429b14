"""Leaves that take and compare images."""

from __future__ import annotations

from typing import Any

from grip_bt.errors import SensorError
from grip_bt.operation import Operation
from grip_bt.ports import Camera
from grip_bt.values import Grasp, RgbdFrame

from .difference import Change, Thresholds, compare
from .leaf import OperationLeaf, Status
from .objects import closing_point


class Capture(OperationLeaf):
    """Take one frame with the sensor that the manifest's `settings` name."""

    camera: Camera

    def prepare(self) -> None:
        """Look the sensor up."""
        self.camera = self.context.camera(self.manifest.settings["sensor"])

    def start(self) -> Operation[RgbdFrame]:
        """Ask for a frame."""
        return self.camera.capture()

    def finish(self, result: RgbdFrame) -> Status:
        """Hand out the frame, and its points where somebody takes them."""
        points = {"points": result.cloud()} if "points" in self.writers else {}
        return self.end(frame=result, **points)


class ImageDifference(OperationLeaf):
    """Decide from a frame before and one after a pick whether the object was taken.

    This is GRIP's image-difference check, with depth added: `compare` says how pixels are classified. The object
    counts as held when enough of its pixels show the table now, and when not much has appeared elsewhere on the
    table: what was only pushed aside, or fell out of the hand, appears there. What left the camera's view altogether
    can't be told from what is held. Without a grasp, everything above the table is looked at.
    """

    def start(self) -> Operation[Change]:
        """Compare in a worker."""
        before: RgbdFrame = self.read("before")
        after: RgbdFrame = self.read("after")
        grasp: Grasp | None = self.read("grasp")
        if before.depth.info != after.depth.info:
            raise SensorError("the two frames were not taken by one camera that stood still")
        p = self.params
        limits = Thresholds(p["color_threshold"], p["depth_threshold"], p["table"], p["max_height"], p["radius"])
        place = None if grasp is None else closing_point(grasp)
        return self.context.run_in_worker(lambda: compare(before, after, place, limits))

    def finish(self, result: Change) -> Status:
        """Judge."""
        p = self.params
        if result.object_pixels < p["min_pixels"]:
            raise SensorError(
                f"only {result.object_pixels} pixels showed an object before the pick; {p['min_pixels']} are needed",
                object_pixels=result.object_pixels,
            )
        vacated, appeared = result.vacated, result.appeared
        measured: dict[str, Any] = {"vacated": vacated, "appeared": appeared, "object_pixels": result.object_pixels}
        outputs = {"fraction": vacated}
        if vacated < p["min_vacated"]:
            text = f"only {vacated:.0%} of the object's place is empty; {p['min_vacated']:.0%} are needed"
            return self.fail("not_held", text, outputs=outputs, **measured)
        if appeared > p["max_appeared"]:
            text = f"something as large as {appeared:.0%} of the object appeared elsewhere on the table"
            return self.fail("not_held", text, outputs=outputs, **measured)
        return self.end(**outputs)
