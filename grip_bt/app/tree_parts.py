"""Running a machine of SMACH whose states tick trees: with the project's nodes and the parts that these need."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from grip_bt.runtime import TreeRun

from .execute import RobotKind
from .project import find_project
from .resources import Progress, open_resources, silent


@contextmanager
def tree_run(
    path: str | Path,
    needs: Collection[str] = (),
    *,
    robot: RobotKind = "sim",
    seed: int = 0,
    pace: float | None = None,
    progress: Progress = silent,
) -> Iterator[TreeRun]:
    """Start what the nodes of a machine need; everything is closed at the end.

    Args:
        path: a file of the project whose nodes, robot and components are meant.
        needs: catalogue ids of the nodes.
        robot: simulated, or fake parts that do as asked.
        seed: of the simulated world.
        pace: simulated seconds per second; None for as fast as it goes.
        progress: told of each part that came up.

    Raises:
        GripError: a part of the robot, or a component, can't be started.
    """
    project = find_project(path)
    with open_resources(project, needs, robot, seed, pace, progress) as resources:
        with TreeRun(resources.context(), project.catalog()) as run:
            yield run
