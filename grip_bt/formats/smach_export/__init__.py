"""A task as Python source of SMACH: the machine that `grip_bt.compilers.to_machine` makes, as people write it."""

from __future__ import annotations

import os
from pathlib import Path

from grip_bt.base.python_literals import py
from grip_bt.codegen.render import template
from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.machine_table import state_labels
from grip_bt.compilers.resolve import resolve
from grip_bt.compilers.scopes import Scopes
from grip_bt.formats.python_source import call, comment
from grip_bt.task import model
from grip_bt.task.catalog import Catalog

from .containers import add, machine, state
from .forms import smach_form
from .states import SourceBuilder, initial, set_key

__all__ = ["export"]


def _assemble(builder: SourceBuilder, folder: Path) -> str:
    trees = bool(builder.nodes or builder.trees or "Choose" in builder.parts)
    plain = not trees and all(_importable(file) for file in builder.modules)
    places = {file: Path(os.path.relpath(file, folder)) for file in builder.modules}
    names, folders = list(builder.nodes), dict.fromkeys(place.parent.as_posix() for place in places.values())
    flat = py(names)
    return template(__package__, "machine.py.j2").render(
        doc=_docstring(builder, trees, plain),
        trees=trees,
        plain=plain,
        ticked=builder.nodes or builder.trees,
        parts=builder.parts,
        nodes=flat if len(flat) < 80 else "[\n" + "".join(f"    {py(name)},\n" for name in names) + "]",
        modules=builder.modules,
        places={file: f"HERE / {py(place.as_posix())}" for file, place in places.items()},
        folders=["HERE" if folder == "." else f"HERE / {py(folder)}" for folder in folders],
        functions=builder.functions,
        run="run" if trees else "",
        built=builder.built,
        body="\n".join(builder.body[1:] if builder.body[0] == "" and not builder.built else builder.body),
        inputs=list(builder.resolved.task.inputs),
    )


def _docstring(builder: SourceBuilder, trees: bool, plain: bool) -> str:
    task, about = builder.resolved.task, _stands_on(builder, trees, plain)
    if task.inputs:
        about += f" Its inputs are userdata of the machine, and arguments of the program: {', '.join(task.inputs)}."
    said = [f"The task {task.name} as a machine of SMACH."]
    for text in (task.doc, about):
        said += ["", *(line.removeprefix("# ") for line in comment(text).split("\n"))] if text.strip() else []
    return "\n".join(said).replace("\\", "\\\\").replace('"""', '\\"\\"\\"')


def _stands_on(builder: SourceBuilder, trees: bool, plain: bool) -> str:
    if not trees and not plain:
        return "It needs GRIP, which reads the old Python of its states."
    if not trees:
        return "It needs smach: that of ROS, or grip_bt.smach_compat after its install()."
    about = "States called BehaviourTree tick a node of the task as GRIP does."
    if builder.trees:
        listed = ", ".join(f"{path} ({kind})" for path, kind in builder.trees.items())
        about += f" These have parts that a machine of SMACH has no equivalent for: {listed}."
    return about


def _importable(file: Path) -> bool:
    try:
        compile(file.read_bytes(), str(file), "exec")
    except (OSError, SyntaxError, ValueError):
        return False
    return file.stem.isidentifier()


def export(task: model.Task, catalog: Catalog, folder: Path | None = None) -> str:
    """Return a Python file that builds the machine of a task.

    The machine does what `grip_bt.compilers.to_machine` makes of the task. What SMACH has no equivalent for (what
    interrupts a running child, GRIP's own leaves, conditions on entry) is one state each, `BehaviourTree`, that ticks.

    Args:
        task: the document.
        catalog: where the leaves' manifests are.
        folder: where the file will lie, for paths of legacy code relative to it; by default the current one.

    Raises:
        InvalidTaskError: the task is wrong.
    """
    builder = SourceBuilder(resolve(task, catalog))
    _root(builder)
    return _assemble(builder, (folder or Path.cwd()).resolve())


def _root(builder: SourceBuilder) -> None:
    task, part, outcomes = builder.resolved.task, builder.resolved.root, list(builder.resolved.task.outcomes)
    needed: Refined = {(outcome, code) for (_, outcome, code), _ in builder.resolved.ends if code is not None}
    ends = {o if code is None else f"{o}.{code}": target for (_, o, code), target in builder.resolved.ends}
    # The root is a state of the task where it has variables of its own, or where SMACH would take an outcome of the
    # task for a state of the root.
    apart = part.declares or set(state_labels(part).values()) & set(outcomes)
    if smach_form(part, needed) == "machine" and not apart:
        machine(builder, part, needed, "task", ends, outcomes, lambda: _values(builder))
        return
    made = state(builder, part, needed)
    builder.body.append("")
    builder.write(call("smach.StateMachine", outcomes=outcomes), "task")
    _values(builder)
    name = task.name
    while name in outcomes:
        name += "'"
    builder.body.append("    with task:")
    add(builder, name, made, part, needed, ends)


def _values(builder: SourceBuilder) -> None:
    """Write the initial values of the task's own variables; a null that stands for no value isn't written."""
    unwritten = {
        part.node.in_[port]
        for part in builder.resolved.root.walk()
        if isinstance(part.node, model.Leaf)
        for port in part.node.with_.get("unwritten", ())
        if port in part.node.in_
    }
    for cell in builder.resolved.scopes[Scopes.TASK].cells.values():
        for value in initial(builder.resolved.task.variables, cell):
            if value is not None or cell.name not in unwritten:
                set_key(builder, "task.userdata", cell.name, value)
