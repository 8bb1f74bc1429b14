"""A task as Python source of SMACH: the machine that `grip_bt.compilers.to_machine` makes, as people write it."""

from __future__ import annotations

import os
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from grip_bt.base.python_literals import py
from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.machine_table import state_labels
from grip_bt.compilers.resolve import Part, resolve
from grip_bt.compilers.scopes import Scopes
from grip_bt.formats.python_source import call, comment
from grip_bt.task import model
from grip_bt.task.catalog import Catalog

from .containers import add, machine, state
from .forms import smach_form
from .states import SourceBuilder, initial, set_key


def assemble(builder: SourceBuilder, folder: Path) -> str:
    """Return the whole file.

    Args:
        builder: what it holds.
        folder: where it will lie.
    """
    trees = bool(builder.nodes or builder.trees or builder.classes)
    plain = not trees and all(_importable(file) for file in builder.modules)
    places = {file: Path(os.path.relpath(file, folder)) for file in builder.modules}
    return (
        _environment()
        .get_template("machine.py.j2")
        .render(
            doc=_docstring(builder, trees, plain),
            trees=trees,
            plain=plain,
            ticked=builder.nodes or builder.trees,
            parts=builder.parts,
            classes=builder.classes,
            nodes=_listed(list(builder.nodes)),
            modules=builder.modules,
            places={file: f"HERE / {py(place.as_posix())}" for file, place in places.items()},
            folders=list(dict.fromkeys(_folder(place.parent.as_posix()) for place in places.values())),
            functions=builder.functions,
            run="run" if trees else "",
            built=builder.built,
            body="\n".join(builder.body[1:] if builder.body[0] == "" and not builder.built else builder.body),
            inputs=list(builder.resolved.task.inputs),
        )
    )


def _environment() -> Environment:
    return Environment(
        loader=PackageLoader(__package__),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # what is made is Python; values enter it as literals alone
    )


def _docstring(builder: SourceBuilder, trees: bool, plain: bool) -> str:
    task = builder.resolved.task
    said = [f"The task {task.name} as a machine of SMACH."]
    if task.doc.strip():
        said += ["", *_wrapped(task.doc)]
    said += ["", *_wrapped(_about(builder, trees, plain))]
    return "\n".join(said).replace("\\", "\\\\").replace('"""', '\\"\\"\\"')


def _about(builder: SourceBuilder, trees: bool, plain: bool) -> str:
    inputs = builder.resolved.task.inputs
    about = _stands_on(builder, trees, plain)
    if inputs:
        about += f" Its inputs are userdata of the machine, and arguments of the program: {', '.join(inputs)}."
    return about


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


def _wrapped(text: str) -> list[str]:
    return [line.removeprefix("# ") for line in comment(text).split("\n")]


def _folder(place: str) -> str:
    return "HERE" if place == "." else f"HERE / {py(place)}"


def _importable(file: Path) -> bool:
    """Tell whether Python 3 can import a file by its name."""
    try:
        compile(file.read_bytes(), str(file), "exec")
    except (OSError, SyntaxError, ValueError):
        return False
    return file.stem.isidentifier()


def _listed(names: list[str]) -> str:
    flat = py(names)
    return flat if len(flat) < 80 else "[\n" + "".join(f"    {py(name)},\n" for name in names) + "]"


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
    return assemble(builder, (folder or Path.cwd()).resolve())


def _root(builder: SourceBuilder) -> None:
    """Write the machine of the whole task, called `task`."""
    task, part, outcomes = builder.resolved.task, builder.resolved.root, list(builder.resolved.task.outcomes)
    needed: Refined = {(outcome, code) for (_, outcome, code), _ in builder.resolved.ends if code is not None}
    ends = {o if code is None else f"{o}.{code}": target for (_, o, code), target in builder.resolved.ends}
    if smach_form(part, needed) == "machine" and not _apart(part, outcomes):
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


def _apart(part: Part, outcomes: list[str]) -> bool:
    """Tell whether the root has to be a state of the task.

    Either it has variables of its own, or an outcome of the task has the name of a state of its root, which SMACH
    would take it for.
    """
    return part.declares or bool(set(state_labels(part).values()) & set(outcomes))


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
