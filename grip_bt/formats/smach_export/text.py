"""The file around the machine: what it says, imports and needs, and how it is run."""

from __future__ import annotations

import os
from pathlib import Path

from grip_bt.base.python_literals import py

from ..standalone.layout import comment
from .plan import Plan

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


def assemble(plan: Plan, folder: Path) -> str:
    """Return the whole file.

    Args:
        plan: what it holds.
        folder: where it will lie.
    """
    trees = bool(plan.nodes or plan.trees or plan.classes)
    plain = not trees and all(_importable(file) for file in plan.modules)
    sections = [_docstring(plan, trees, plain), _imports(plan, folder, trees, plain)]
    if "count" in plan.parts:
        sections.append("\n\n" + _COUNT.rstrip("\n"))
    if "begin_anew" in plan.parts:
        sections.append("\n\n" + _BEGIN_ANEW.rstrip("\n"))
    sections += ["\n\n" + function for function in plan.functions]
    sections.append("\n\n" + _build(plan, trees))
    sections.append("\n\n" + _main(plan, trees, plain))
    return "\n".join(sections) + "\n"


def _docstring(plan: Plan, trees: bool, plain: bool) -> str:
    task = plan.resolved.task
    said = [f"The task {task.name} as a machine of SMACH."]
    if task.doc.strip():
        said += ["", *_wrapped(task.doc)]
    said += ["", *_wrapped(_about(plan, trees, plain))]
    text = "\n".join(said).replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    return f'"""{text}\n"""\n'


def _about(plan: Plan, trees: bool, plain: bool) -> str:
    inputs = plan.resolved.task.inputs
    about = _stands_on(plan, trees, plain)
    if inputs:
        about += f" Its inputs are userdata of the machine, and arguments of the program: {', '.join(inputs)}."
    return about


def _stands_on(plan: Plan, trees: bool, plain: bool) -> str:
    if not trees and not plain:
        return "It needs GRIP, which reads the old Python of its states."
    if not trees:
        return "It needs smach: that of ROS, or grip_bt.smach_compat after its install()."
    about = "States called BehaviourTree tick a node of the task as GRIP does."
    if plan.trees:
        listed = ", ".join(f"{path} ({kind})" for path, kind in plan.trees.items())
        about += f" These have parts that a machine of SMACH has no equal for: {listed}."
    return about


def _wrapped(text: str) -> list[str]:
    return [line.removeprefix("# ") for line in comment(text).split("\n")]


def _imports(plan: Plan, folder: Path, trees: bool, plain: bool) -> str:
    standard = ["import copy"] if "begin_anew" in plan.parts else []
    if plan.modules:
        standard += (["import sys"] if plain else []) + ["from pathlib import Path"]
    own = ["from grip_bt import BehaviourTree"] if plan.nodes or plan.trees else []
    own.append("import smach" if plain else "from grip_bt import smach_compat as smach")
    if plan.modules and not plain:
        own.append("from grip_bt.nodes.smach_source import load_legacy")
    if plan.classes:
        own.append(f"from grip_bt.runtime import {', '.join(sorted(plan.classes))}")
    lines = [*standard, *([""] if standard else []), *own]
    if trees:
        lines += ["", f"NODES = {_listed(list(plan.nodes))}"]
    if plan.modules:
        lines += ["", "HERE = Path(__file__).resolve().parent", *_legacy(plan, folder, plain)]
    return "\n".join(lines)


def _legacy(plan: Plan, folder: Path, plain: bool) -> list[str]:
    places = {file: Path(os.path.relpath(file, folder)) for file in plan.modules}
    if not plain:
        return [f"{plan.modules[file]} = load_legacy(HERE / {py(place.as_posix())})" for file, place in places.items()]
    folders = dict.fromkeys(place.parent.as_posix() for place in places.values())
    lines = [f"sys.path.append(str({'HERE' if each == '.' else f'HERE / {py(each)}'}))" for each in folders]
    for file in plan.modules:
        alias = "" if plan.modules[file] == file.stem else f" as {plan.modules[file]}"
        lines.append(f"import {file.stem}{alias}  # noqa: E402")
    return ["", *lines]


def _importable(file: Path) -> bool:
    """Tell whether Python 3 can import a file by its name."""
    try:
        compile(file.read_bytes(), str(file), "exec")
    except (OSError, SyntaxError, ValueError):
        return False
    return file.stem.isidentifier()


def _build(plan: Plan, trees: bool) -> str:
    lines = [f"def build({'run' if trees else ''}):"]
    lines.append('    """Return the machine; build another one for another run."""')
    lines += [f"    {name} = {source}" for source, name in plan.built.items()]
    body = plan.body[1:] if plan.body[0] == "" and not plan.built else plan.body
    return "\n".join([*lines, *body, "    return task"])


def _main(plan: Plan, trees: bool, plain: bool) -> str:
    """Return what the file does as a program; inputs are its arguments."""
    inputs = list(plan.resolved.task.inputs)
    loaded = ["    from grip_bt import tree_run"] if trees else []
    if inputs:
        own_sys = [] if plan.modules and plain else ["    import sys"]
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
