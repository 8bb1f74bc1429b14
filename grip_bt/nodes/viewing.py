"""The leaf that moves an arm to where the robot doesn't hide what a camera is to see."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import ViewBlockedError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Camera
from grip_bt.base.values import JointState
from grip_bt.nodes.camera_views import outline, share, within

from .arm import ArmLeaf
from .leaf import Status
from .motion import first_of, go
from .perception import check_region

STEP = np.radians(15)
"""By so much the arm's first joint is turned from one candidate to the next."""


class ClearView(ArmLeaf):
    """Go to a named state or, where the robot would hide too much from there, to the nearest posture that hides less.

    Candidates are the arm's named states, and the first of them with the arm turned about its first joint: an arm that
    looks at a table from its side is out of the view when it looks elsewhere. What each would hide is known before
    anything moves, from the robot's hulls (`sight.outline`).
    """

    camera: Camera

    def prepare(self) -> None:
        """Look up arm, camera and state."""
        super().prepare()
        self.camera = self.context.camera(self.params["sensor"])
        check_region(self.path, self.params["region"])
        states = self.arm.named_states()
        if self.params["state"] not in states:
            raise UnknownNameError("named state", self.params["state"], states, where=self.path)

    def start(self) -> Operation[JointState]:
        """Find the candidates in a worker, then go to the first that can be reached."""
        return self.context.run_in_worker(self._clear).then(
            lambda clear: first_of(partial(go, self.arm, state) for state in clear)
        )

    def finish(self, result: JointState) -> Status:
        """Hand out what was measured."""
        return self.end(reached=result)

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
