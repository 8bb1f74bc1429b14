"""What every node of a task adds to a py_trees behaviour: a path, a labelled end with a reason, and an observer.

`active` spans one activation, from the first tick to the end or the interruption. It isn't `status == RUNNING`:
py_trees sets a composite's status only at the end of its tick, and an exception may come first.
"""

from __future__ import annotations

from collections.abc import Mapping

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.values import Failure

from .observer import SILENT, Observer

STATUS = {"success": Status.SUCCESS, "failure": Status.FAILURE}
LABEL = {Status.SUCCESS: "success", Status.FAILURE: "failure"}


class Node(Behaviour):
    """Mixed in before a class of py_trees.

    Attributes:
        path: the node's path in the task; `/` for the root.
        meaning: each outcome that the node can end with -> `success` or `failure`.
        outcome: the label of the last end, None while running or after an interruption.
        failure: the reason of the last end, where there is one.
        active: whether an activation is under way.
    """

    status: Status
    feedback_message: str
    path: str = ""
    meaning: Mapping[str, str] = {"success": "success", "failure": "failure"}
    outcome: str | None = None
    failure: Failure | None = None
    active: bool = False
    observer: Observer = SILENT

    @property
    def code(self) -> str | None:
        """The code of the last failure, or None."""
        return self.failure.code if self.failure is not None else None

    def begin(self) -> None:
        """Forget the last end and report that an activation begins."""
        self.outcome, self.failure, self.active = None, None, True
        self.observer.entered(self.path)

    def conclude(self, status: Status) -> None:
        """Settle `outcome` and `failure` of an activation that ends with `status`."""
        if self.outcome is None:
            self.outcome = "success" if status is Status.SUCCESS else "failure"

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End an activation, or interrupt it (INVALID); an interrupted one has no outcome."""
        if new_status in LABEL:
            self.conclude(new_status)
        else:
            self.outcome, self.failure = None, None
        try:
            super().stop(new_status)
        finally:
            if self.active:
                self.active = False
                if self.outcome is None:
                    self.observer.interrupted(self.path)
                else:
                    self.observer.ended(self.path, self.outcome, self.failure)


def halt(root: Behaviour) -> list[tuple[str, Exception]]:
    """Interrupt everything below and including `root`, at once, and leave nothing running.

    Works leaf by leaf, since after an exception a composite's status may not show what runs below it.

    Returns:
        What was raised while stopping, with the path of the node; the rest was stopped all the same.
    """
    trouble: list[tuple[str, Exception]] = []
    for node in list(root.iterate()):
        if node.status == Status.RUNNING or getattr(node, "active", False):
            try:
                node.stop(Status.INVALID)
            except Exception as error:  # noqa: BLE001 - one broken leaf must not keep others from being stopped
                node.status = Status.INVALID
                trouble.append((getattr(node, "path", node.name), error))
    return trouble
