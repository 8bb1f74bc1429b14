"""A task as Python source of SMACH: the machine that `grip_bt.compilers.to_machine` makes, as people write it."""

from __future__ import annotations

from pathlib import Path

from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.resolve import Part, resolve
from grip_bt.compilers.scopes import Scopes
from grip_bt.compilers.transitions import state_labels
from grip_bt.task import model
from grip_bt.task.catalog import Catalog

from ..standalone.layout import call
from .containers import add, machine, state
from .forms import form_of
from .plan import Plan, initial, set_key
from .text import assemble


def export(task: model.Task, catalog: Catalog, folder: Path | None = None) -> str:
    """Return a Python file that builds the machine of a task.

    The machine does what `grip_bt.compilers.to_machine` makes of the task. What SMACH has no equal for (what interrupts
    a running child, GRIP's own leaves, conditions on entry) is one state each, `BehaviourTree`, which ticks it.

    Args:
        task: the document.
        catalog: where the leaves' manifests are.
        folder: where the file will lie, for paths of legacy code relative to it; by default the current one.

    Raises:
        InvalidTaskError: the task is wrong.
    """
    plan = Plan(resolve(task, catalog))
    _root(plan)
    return assemble(plan, (folder or Path.cwd()).resolve())


def _root(plan: Plan) -> None:
    """Write the machine of the whole task, called `task`."""
    task, part, outcomes = plan.resolved.task, plan.resolved.root, list(plan.resolved.task.outcomes)
    needed: Refined = {(outcome, code) for (_, outcome, code), _ in plan.resolved.ends if code is not None}
    ends = {o if code is None else f"{o}.{code}": target for (_, o, code), target in plan.resolved.ends}
    if form_of(part, needed) == "machine" and not _apart(part, outcomes):
        machine(plan, part, needed, "task", ends, outcomes, lambda: _values(plan))
        return
    made = state(plan, part, needed)
    plan.body.append("")
    plan.write(call("smach.StateMachine", outcomes=outcomes), "task")
    _values(plan)
    name = task.name
    while name in outcomes:
        name += "'"
    plan.body.append("    with task:")
    add(plan, name, made, part, needed, ends)


def _apart(part: Part, outcomes: list[str]) -> bool:
    """Tell whether the root has to be a state of the task.

    Either it has variables of its own, or an outcome of the task has the name of a state of its root, which SMACH
    would take it for.
    """
    return part.declares or bool(set(state_labels(part).values()) & set(outcomes))


def _values(plan: Plan) -> None:
    """Write the initial values of the task's own variables; a null that stands for no value isn't written."""
    unwritten = {
        part.node.in_[port]
        for part in plan.resolved.root.walk()
        if isinstance(part.node, model.Leaf)
        for port in part.node.with_.get("unwritten", ())
        if port in part.node.in_
    }
    for cell in plan.resolved.scopes[Scopes.TASK].cells.values():
        for value in initial(plan.resolved.task.variables, cell):
            if value is not None or cell.name not in unwritten:
                set_key(plan, "task.userdata", cell.name, value)
