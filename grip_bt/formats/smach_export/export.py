"""A task as Python source of SMACH: the machine that `grip_bt.compilers.to_machine` makes, as people write it."""

from __future__ import annotations

import os
from pathlib import Path

from grip_bt.base.python_literals import py
from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.resolve import Part, resolve
from grip_bt.compilers.scopes import Scopes
from grip_bt.compilers.transitions import state_labels
from grip_bt.task import model
from grip_bt.task.catalog import Catalog

from ..standalone.layout import call, comment
from .containers import add, machine, state
from .forms import smach_form
from .states import SourceBuilder, initial, set_key

_COUNT = '''class Count(smach.State):
    """Counts the attempts of its machine: `again`, or `enough` after so many."""

    def __init__(self, times):
        smach.State.__init__(self, outcomes=["again", "enough"])
        self.times, self.done = times, 0

    def begin(self, userdata, states):
        """Begin to count; called when the machine is entered."""
        self.done = 0

    def execute(self, userdata):
        """Count one attempt."""
        self.done += 1
        return "enough" if self.done >= self.times else "again"
'''
_BEGIN_ANEW = '''def begin_anew(userdata, states, values, unset):
    """Give a container's own variables their first values again; called when it is entered."""
    for key, value in values.items():
        userdata[key] = copy.deepcopy(value)
    for key in unset:
        userdata._data.pop(key, None)
'''


def assemble(builder: SourceBuilder, folder: Path) -> str:
    """Return the whole file.

    Args:
        builder: what it holds.
        folder: where it will lie.
    """
    trees = bool(builder.nodes or builder.trees or builder.classes)
    plain = not trees and all(_importable(file) for file in builder.modules)
    sections = [_docstring(builder, trees, plain), _imports(builder, folder, trees, plain)]
    if "count" in builder.parts:
        sections.append("\n\n" + _COUNT.rstrip("\n"))
    if "begin_anew" in builder.parts:
        sections.append("\n\n" + _BEGIN_ANEW.rstrip("\n"))
    sections += ["\n\n" + function for function in builder.functions]
    sections.append("\n\n" + _build(builder, trees))
    sections.append("\n\n" + _main(builder, trees, plain))
    return "\n".join(sections) + "\n"


def _docstring(builder: SourceBuilder, trees: bool, plain: bool) -> str:
    task = builder.resolved.task
    said = [f"The task {task.name} as a machine of SMACH."]
    if task.doc.strip():
        said += ["", *_wrapped(task.doc)]
    said += ["", *_wrapped(_about(builder, trees, plain))]
    text = "\n".join(said).replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    return f'"""{text}\n"""\n'


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
        about += f" These have parts that a machine of SMACH has no equal for: {listed}."
    return about


def _wrapped(text: str) -> list[str]:
    return [line.removeprefix("# ") for line in comment(text).split("\n")]


def _imports(builder: SourceBuilder, folder: Path, trees: bool, plain: bool) -> str:
    standard = ["import copy"] if "begin_anew" in builder.parts else []
    if builder.modules:
        standard += (["import sys"] if plain else []) + ["from pathlib import Path"]
    own = ["from grip_bt import BehaviourTree"] if builder.nodes or builder.trees else []
    own.append("import smach" if plain else "from grip_bt import smach_compat as smach")
    if builder.modules and not plain:
        own.append("from grip_bt.nodes.smach_source import load_legacy")
    if builder.classes:
        own.append(f"from grip_bt.runtime import {', '.join(sorted(builder.classes))}")
    lines = [*standard, *([""] if standard else []), *own]
    if trees:
        lines += ["", f"NODES = {_listed(list(builder.nodes))}"]
    if builder.modules:
        lines += ["", "HERE = Path(__file__).resolve().parent", *_legacy(builder, folder, plain)]
    return "\n".join(lines)


def _legacy(builder: SourceBuilder, folder: Path, plain: bool) -> list[str]:
    places = {file: Path(os.path.relpath(file, folder)) for file in builder.modules}
    if not plain:
        return [
            f"{builder.modules[file]} = load_legacy(HERE / {py(place.as_posix())})" for file, place in places.items()
        ]
    folders = dict.fromkeys(place.parent.as_posix() for place in places.values())
    lines = [f"sys.path.append(str({'HERE' if each == '.' else f'HERE / {py(each)}'}))" for each in folders]
    for file in builder.modules:
        alias = "" if builder.modules[file] == file.stem else f" as {builder.modules[file]}"
        lines.append(f"import {file.stem}{alias}  # noqa: E402")
    return ["", *lines]


def _importable(file: Path) -> bool:
    """Tell whether Python 3 can import a file by its name."""
    try:
        compile(file.read_bytes(), str(file), "exec")
    except (OSError, SyntaxError, ValueError):
        return False
    return file.stem.isidentifier()


def _build(builder: SourceBuilder, trees: bool) -> str:
    lines = [f"def build({'run' if trees else ''}):"]
    lines.append('    """Return the machine; build another one for another run."""')
    lines += [f"    {name} = {source}" for source, name in builder.built.items()]
    body = builder.body[1:] if builder.body[0] == "" and not builder.built else builder.body
    return "\n".join([*lines, *body, "    return task"])


def _main(builder: SourceBuilder, trees: bool, plain: bool) -> str:
    """Return what the file does as a program; inputs are its arguments."""
    inputs = list(builder.resolved.task.inputs)
    loaded = ["    from grip_bt import tree_run"] if trees else []
    if inputs:
        own_sys = [] if builder.modules and plain else ["    import sys"]
        loaded = [*own_sys, "    from ast import literal_eval", *([""] if trees else []), *loaded]
    lines = ['if __name__ == "__main__":', *loaded, *([""] if loaded else [])]
    depth = "    "
    if trees:
        lines.append("    with tree_run(__file__, NODES) as run:")
        depth += "    "
    made = f"build({'run' if trees else ''})"
    if not inputs:
        return "\n".join([*lines, f"{depth}print({made}.execute())"])
    body = [
        f"machine = {made}",
        f"for given in sys.argv[1:]:  # {inputs[0]}=VALUE, a Python literal",
        '    name, _, value = given.partition("=")',
        "    machine.userdata[name] = literal_eval(value)",
        "print(machine.execute())",
    ]
    return "\n".join([*lines, *(depth + line for line in body)])


def _listed(names: list[str]) -> str:
    flat = py(names)
    return flat if len(flat) < 80 else "[\n" + "".join(f"    {py(name)},\n" for name in names) + "]"


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
