"""A case run by the Python source of SMACH that its task is exported to."""

from __future__ import annotations

from typing import Any

from parity_world import MAX_TURNS, Run, _factory, _world, catalog_of

from grip_bt import smach_compat
from grip_bt.base.errors import NodeError
from grip_bt.compilers import Halted
from grip_bt.formats.smach_export import export
from grip_bt.runtime import TreeRun
from grip_bt.task.model import Task


def run_exported(case: dict[str, Any]) -> tuple[Run, str]:
    """Return what the exported source does with scripted leaves, and that source."""
    task = Task.model_validate(case["task"])
    catalog = catalog_of(case)
    source = export(task, catalog)
    module: dict[str, Any] = {"__name__": "exported", "__file__": __file__}
    exec(compile(source, "exported.py", "exec"), module)
    world = _world(case, task, None)
    run = TreeRun(world, catalog, leaf_factory=_factory(world), pacer=world)  # type: ignore[arg-type]
    quiet = lambda text: None  # noqa: E731
    smach_compat.set_loggers(quiet, quiet, quiet, quiet)
    machine = module["build"](run)
    world.request_preempt = machine.request_preempt
    if world.preempt_at == -1:
        machine.request_preempt()
    try:
        outcome = machine.execute()
        end: tuple[Any, ...] = (outcome, task.outcomes[outcome])
    except BaseException as error:
        cause: BaseException | None = run.shared.error or error
        if isinstance(cause, Halted):
            end = ("stopped",)
        elif isinstance(cause, NodeError):
            end = ("error", cause.path, str(cause.cause))
        else:
            raise
    data = {("", key): machine.userdata[key] for key in machine.userdata.keys()}
    over = world.over_budget or world.turns > MAX_TURNS
    return Run(end, world.trace, [], data, over, world.turns), source
