"""The leaf that decides, from all the evidence that there is, whether a hand holds something."""

from __future__ import annotations

from grip_bt.base.operation import Operation
from grip_bt.base.values import DepthImage, Grasp, RgbdFrame

from .difference import Change, Thresholds
from .evidence import Limits, Voice, hand_voices, holds, image_voice, sight_voice
from .hand import HandLeaf
from .leaf import Status
from .perception import changed


class Holds(HandLeaf):
    """Ask the hand's contacts and fingers, and a camera where frames are bound; see `evidence` for the rule.

    A frame after the pick lets the camera look for the object in the hand, and one before it besides lets it look
    whether the object's place is empty.
    """

    def start(self) -> Operation[list[Voice]]:
        """Ask; images are looked at in a worker."""
        p = self.params
        voices = hand_voices(self.hand, Limits(p["force"], p["links"], p["least_open"], p["most_moved"]))
        before: RgbdFrame | None = self.read("before")
        after: RgbdFrame | None = self.read("after")
        grasp: Grasp | None = self.read("grasp")
        asked = Operation.finished(voices)
        if after is None:
            return asked
        depth = after.depth
        asked = asked.then(lambda said: self.context.run_in_worker(lambda: [*said, self._seen(depth)]))
        if before is None:
            return asked
        frames = before, after
        return asked.then(lambda said: self._compared(said, *frames, grasp))

    def finish(self, result: list[Voice]) -> Status:
        """Put the voices together."""
        voices = {voice.name: voice.held for voice in result}
        if holds(result):
            return self.end(voices=voices)
        against = [voice for voice in result if voice.held is False]
        text = "; ".join(map(str, against)) or "nothing of the hand says that it holds something"
        agree = [voice.name for voice in result if voice.held]
        if against and agree:
            text += f"; against {' and '.join(agree)}"
        return self.fail("not_held", text, outputs={"voices": voices}, voices={v.name: str(v) for v in result})

    def _seen(self, depth: DepthImage) -> Voice:
        scene = self.context.scene()
        return sight_voice(depth, scene, self.hand.name, scene.robot())

    def _compared(
        self, said: list[Voice], before: RgbdFrame, after: RgbdFrame, grasp: Grasp | None
    ) -> Operation[list[Voice]]:
        p = self.params

        def judged(change: Change) -> Operation[list[Voice]]:
            return Operation.finished([*said, image_voice(change, p["min_vacated"], p["max_appeared"])])

        return changed(self.context, before, after, grasp, Thresholds(table=p["table"])).then(judged)
