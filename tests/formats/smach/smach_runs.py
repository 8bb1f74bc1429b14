"""Runs a legacy machine on smach_compat and as an imported task, and notes what happens."""

import atexit
from functools import cache
from pathlib import Path

from grip_bt import smach_compat
from grip_bt.app.project.catalogue import project_catalog
from grip_bt.compilers import to_machine, to_tree
from grip_bt.formats.smach import ImportedFile, Recorder, import_file, make_tasks
from grip_bt.formats.smach.facts import facts_of
from grip_bt.formats.smach.found import Way
from grip_bt.formats.smach.leaves import Meanings
from grip_bt.nodes.node import Observer
from grip_bt.nodes.smach_construction import built_in, run_as_main
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.nodes.smach_source import load_legacy
from grip_bt.runtime import RunContext, Runner
from grip_bt.task import Leaf, dumps, read, walk

DATA = Path(__file__).parent / "data"
COMPILERS = {"bt": to_tree, "sm": to_machine}


class Trace(Observer):
    def __init__(self, leaves):
        self.leaves, self.ends = leaves, []

    def ended(self, path, outcome, failure):
        if path in self.leaves:
            self.ends.append((path, outcome))


_recorders = []


def record(file, root=None, given=None, **more):
    """Import a file in a recording process, which all tests share; one that lies there for all tests, once."""
    if (root, given, more, file.parent) == (None, None, {}, DATA):
        return _recorded(file)
    return _record(file, root, given, **more)


@cache
def _recorded(file):
    return _record(file)


def _record(file, root=None, given=None, **more):
    if not _recorders:
        _recorders.append(Recorder().__enter__())
        atexit.register(_recorders[0].__exit__)
    return import_file(file, root, _recorders[0], given, **more)


def write_recorded(file, folder, **more):
    """Import a file and return the path of each task."""
    return _written(record(file, **more), folder)


def write(file, folder):
    """Import what `build` of a file builds, in this process, and return the path of its task."""
    build = load_legacy(file, ros=False).build
    result = ImportedFile(file.resolve())
    found = facts_of(build(), result.file)
    found.way = Way("build", result.file, 1, returned=True)
    return _written(make_tasks(result, found.within(), Meanings()), folder)


def _written(imported, folder):
    paths = {name: folder / f"{name}.yaml" for name in imported.tasks}
    write_files(imported, paths, folder / "nodes")
    return imported, paths


def write_files(imported, paths, nodes):
    """Write tasks, and their leaves below a folder of nodes."""
    texts = {path: dumps(imported.tasks[name]) for name, path in paths.items()}
    own = nodes / f"smach_{imported.leaves.stem}"
    texts |= {own / name: text for name, text in imported.leaves.texts(own).items()}
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def run_task(path, target="bt", data=None):
    """Return (outcome, ends of leaves, data) of a run."""
    task = read(path).task
    compiled = COMPILERS[target](task, project_catalog(path), data=data)
    kinds = {path: node.node for path, node in walk(task.root) if isinstance(node, Leaf)}
    trace = Trace({path for path, kind in kinds.items() if kind.split("/")[-1][:5] not in ("next_", "copy_", "preem")})
    runner = Runner(compiled, RunContext())
    runner.observe(trace)
    result = runner.run()
    assert result.error is None, result.error
    return result.outcome, trace.ends, {name: value for (_, name), value in compiled.data.snapshot().items()}


def build_legacy(imported, name):
    """Build the legacy machine of an imported task from where the file gives it."""
    task, legacy = imported.tasks[name], load_legacy(imported.file)
    outermost = [c for c in imported.containers if c.parent is None]
    way = outermost[list(imported.tasks).index(name)].way
    assert task.name == name
    if way.returned:
        made = getattr(legacy, way.builder)
        return eval(f"made({way.calls[-1]})", {"made": made}) if way.called else made
    code = run_as_main(way.file) if way.builder == "__main__" else getattr(legacy, way.builder)
    return built_in(way.file, way.line, code, way.number)


def run_legacy(machine, embedded=()):
    """Return the outcome and the ends of states, containers in `embedded` taken as states."""
    ends = []
    quiet = lambda text: None  # noqa: E731
    smach_compat.set_loggers(quiet, quiet, quiet, quiet)
    _note(machine, "", ends, embedded)
    return task_name(machine.execute()), ends


def _note(container, prefix, ends, embedded):
    for label, state in container.get_children().items():
        path = prefix + label
        if hasattr(state, "get_children") and path not in embedded:
            _note(state, f"{path}/", ends, embedded)
        else:
            _wrap(state, path, ends)


def _wrap(state, path, ends):
    execute = state.execute

    def noted(userdata):
        outcome = execute(userdata)
        ends.append((path, outcome))
        return outcome

    state.execute = noted


GO = """import smach

class Go(smach.State):
    def __init__(self, name='', outcomes=('there', 'lost')):
        smach.State.__init__(self, outcomes=list(outcomes), input_keys=['k'], output_keys=['k'])
        self.name = name
    def execute(self, userdata):
        return 'there'

"""
"""A program begins so whose states are of a class Go."""
STEP = "import smach\n\n\nclass Step(smach.State):\n    def __init__(self, name='x'):\n"
STEP += (
    "        smach.State.__init__(self, outcomes=['done'])\n\n    def execute(self, ud):\n        return 'done'\n\n\n"
)
"""A program begins so whose states are of a class Step."""


def verdicts(imported):
    return [c.verdict for c in imported.containers]


def texts(imported):
    return "\n".join(str(p) for c in imported.containers for p in c.issues)


def recorded(folder, text, name="legacy.py", **more):
    file = folder / name
    file.write_text(GO + text)
    return record(file, **more)
