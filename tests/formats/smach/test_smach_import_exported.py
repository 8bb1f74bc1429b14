"""A machine that is imported and exported again is the machine that it was."""

import inspect
import json
import sys
from pathlib import Path

import pytest
from smach_lowerings import Draw
from smach_runs import write
from smach_sources import source_of

from grip_bt import smach_compat
from grip_bt.app.project.catalogue import project_catalog
from grip_bt.formats.smach_export import export
from grip_bt.task import Leaf, read, walk

GOLDEN = Path(__file__).parents[2] / "smach_compat" / "data" / "smach_golden.jsonl"
CASES = [json.loads(line)["spec"] for line in GOLDEN.read_text().splitlines()]
MACHINES = 40


def exported(name, spec, folder):
    """Return the legacy module and the exported one; None where the import isn't exact or had to copy keys."""
    folder.mkdir()
    file = folder / f"{name}.py"
    file.write_text(source_of(spec))
    found, paths = write(file, folder / "out")
    if {container.verdict for container in found.containers} != {"exact"}:
        return None
    task = read(paths["build"]).task
    if any(isinstance(node, Leaf) and "/copy_" in node.node for _, node in walk(task.root)):
        return None
    text = export(task, project_catalog(paths["build"]), folder)
    if "/next_item" in text:
        return None  # an Iterator that stays a machine, since its ends can't be told apart by names
    assert "BehaviourTree" not in text
    again = folder / f"{name}_again.py"
    again.write_text(text)
    smach_compat.install(ros=False)
    module = {"__name__": again.stem, "__file__": str(again)}
    exec(compile(text, str(again), "exec"), module)
    return sys.modules[name], module


def shape(container, ends=None):
    """Return what a container is made of, with names of outcomes that lead out of it replaced by where they lead."""
    ends = ends or {}
    out = lambda outcome: ends.get(outcome, outcome)  # noqa: E731
    if isinstance(container, smach_compat.Concurrence):
        children = container.get_children()
        rules, default = [], out(container._default_outcome)
        for outcome, when in container._outcome_map.items():
            # what a child with one outcome ends with is no condition
            asked = sorted(c for c in when.items() if len(children[c[0]].get_registered_outcomes()) > 1)
            rules, default = ([*rules, (out(outcome), asked)], default) if asked else (rules, out(outcome))
        rest = {label: shape_of(state, {}) for label, state in children.items()}
        return "Concurrence", rest, sorted(rule for rule in rules if rule[0] != default), default
    if isinstance(container, smach_compat.Iterator):
        ((label, state),) = container.get_children().items()
        final = container._final_outcome_map
        leads = {o: out(final.get(o, o)) for o in sorted(container._break_outcomes)}
        last = out(final.get(container._exhausted_outcome, container._exhausted_outcome))
        about = container._items, sorted(container._loop_outcomes), leads, last
        return "Iterator", label, *about, shape_of(state, {})
    rows = {}
    for label, state in container.get_children().items():
        table = {o: container._transitions[label].get(o) or o for o in state.get_registered_outcomes()}
        table = {o: to if to in container.get_children() else f"-> {out(to)}" for o, to in table.items()}
        if isinstance(state, smach_compat.Container):
            table = {} if not isinstance(state, smach_compat.StateMachine) else table
        rows[label] = table, shape_of(state, {o: t for o, t in edges(container, label, state).items()})
    return "StateMachine", container.get_initial_states(), rows


def edges(container, label, state):
    return {o: container._transitions[label].get(o) or o for o in state.get_registered_outcomes()}


def shape_of(state, ends):
    if isinstance(state, smach_compat.StateMachine):
        return shape(state)
    if isinstance(state, smach_compat.Container):
        return shape(state, ends)
    return type(state).__name__, sorted(state.get_registered_outcomes()), vars(state)["path"]


def runs(module, build, preempt_at):
    """Return the outcome and the trace of a machine of a module."""
    module.TRACE.clear()
    module.ENDED.clear()
    module.WAITING.clear()
    machine = build()
    quiet = lambda text: None  # noqa: E731
    smach_compat.set_loggers(quiet, quiet, quiet, quiet)
    module.WORLD.update(activations=0, preempt_at=preempt_at, request=lambda state: machine.request_preempt())
    return machine.execute(), json.loads(json.dumps(sorted(module.TRACE, key=json.dumps)))


@pytest.mark.parametrize("origin", ["upstream's", "random"])
def test_what_was_imported_exactly_is_exported_as_the_machine_that_it_was(origin, tmp_path):
    specs = CASES[::5] if origin == "upstream's" else [Draw(seed).machine() for seed in range(MACHINES)]
    compared = 0
    for number, spec in enumerate(specs):
        name = f"legacy_{origin[:2]}_{number}"
        made = exported(name, spec, tmp_path / str(number))
        if made is None:
            continue
        legacy, module = made
        assert shape(module["build"]()) == shape(legacy.build()), (number, spec)
        for preempt_at in [()] if "Concurrence" in inspect.getsource(legacy.build) else [(), (0,), (1,), (2,), (1, 3)]:
            wanted = runs(legacy, legacy.build, preempt_at)
            assert runs(legacy, module["build"], preempt_at) == wanted, (number, preempt_at)
        compared += 1
        del sys.modules[name]
    assert compared >= len(specs) // 4
