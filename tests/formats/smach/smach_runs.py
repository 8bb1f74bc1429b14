"""Runs a legacy machine on smach_compat and as an imported task, and notes what happens."""

from grip_bt import smach_compat
from grip_bt.app.project.catalogue import project_catalog
from grip_bt.compilers import to_machine, to_tree
from grip_bt.formats.smach import import_file, write_import
from grip_bt.nodes.node import Observer
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.nodes.smach_source import load_legacy
from grip_bt.runtime import RunContext, Runner
from grip_bt.task import Leaf, read, walk

COMPILERS = {"bt": to_tree, "sm": to_machine}


class Trace(Observer):
    def __init__(self, leaves):
        self.leaves, self.ends = leaves, []

    def ended(self, path, outcome, failure):
        if path in self.leaves:
            self.ends.append((path, outcome))


def write(file, folder):
    """Import a file and return the path of each task."""
    imported = import_file(file)
    paths = {name: folder / f"{name}.yaml" for name in imported.tasks}
    write_import(imported, paths, folder / "nodes")
    return imported, paths


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
    container = next(c for c in imported.containers if getattr(c.entry, "attr", "") == name)
    made = getattr(load_legacy(imported.file), name)
    return made() if container.entry_is_call else made


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
