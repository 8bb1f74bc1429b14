"""A task as a behaviour tree of plain py_trees: `create_root` builds it, `run` ticks it to its end."""

# Task plain_steps, written by `grip convert --to pytrees-py`.
#
# Knock until somebody opens, but not for long; then say so.

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from typing import Any

import py_trees
from py_trees.common import Status


def outcome_of(node: py_trees.behaviour.Behaviour) -> str:
    """Return the label that a node has ended with: its own, or that of its status."""
    return getattr(node, "outcome", None) or node.status.name.lower()


def look_up(
    table: Mapping[str, str], outcome: str, code: str | None = None
) -> str | None:
    """Return where an end leads: by `outcome.code`, else by its outcome."""
    return table.get(f"{outcome}.{code}", table.get(outcome))


class Log(py_trees.behaviours.Success):
    """Logs a sentence, and a value where one is bound."""

    def __init__(self, name: str, message: str, value: Callable[[], Any] | None = None):
        super().__init__(name)
        self.message, self.value = message, value

    def update(self) -> Status:
        more = "" if self.value is None else f": {self.value()!r}"
        self.feedback_message = f"{self.message}{more}"
        logging.getLogger(__name__).info("%s", self.feedback_message)
        return Status.SUCCESS


def create_root() -> py_trees.behaviour.Behaviour:
    """Build the tree."""
    pause = py_trees.timers.Timer("pause", duration=0.01)
    opened = py_trees.behaviours.Success("opened")
    door = py_trees.composites.Selector("door", children=[pause, opened], memory=False)
    knock = py_trees.decorators.Retry("knock", child=door, num_failures=3)
    # Nobody waits longer than this.
    enter = py_trees.decorators.Timeout("enter", child=knock, duration=10.0)
    bow = py_trees.behaviours.Success("bow")
    speak = Log("speak", message="Good day!")
    greet = py_trees.composites.Parallel(
        "greet",
        children=[bow, speak],
        policy=py_trees.common.ParallelPolicy.SuccessOnAll(),
    )
    slam = py_trees.behaviours.Failure("slam")
    shut = py_trees.decorators.FailureIsSuccess("shut", child=slam)
    root = py_trees.composites.Sequence(
        "plain_steps",
        children=[enter, greet, shut],
        memory=True,
    )
    return root


ENDS = {"success": "in", "failure": "out"}


def end_of(root: py_trees.behaviour.Behaviour) -> str:
    """Return the task's outcome; the root has ended."""
    return look_up(ENDS, outcome_of(root))


def run(root: py_trees.behaviour.Behaviour, period: float = 0.05) -> str:
    """Tick every `period` [s] until the tree has ended; return the task's outcome."""
    tree = py_trees.trees.BehaviourTree(root)
    tree.setup()
    try:
        tree.tick()
        while root.status == Status.RUNNING:
            time.sleep(period)
            tree.tick()
    finally:
        for node in root.iterate():
            if node.status == Status.RUNNING:
                node.stop(Status.INVALID)
        tree.shutdown()
    return end_of(root)


if __name__ == "__main__":
    print(run(create_root()))
