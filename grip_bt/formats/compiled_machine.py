"""Walking the containers of a compiled machine and writing the task that does the same.

What a state can't show (parameters, ports, expressions) is in the document that it was made of. What it can show is
read from the machine as it is now: which states there are, in which order, which is the first, and where each end
leads. Edges that were changed since are edges of the new document where it can say them, and else refused by name.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from grip_bt.compilers.behaviour_state import BehaviourState, TaskState
from grip_bt.compilers.machine_table import AGAIN, Table, state_labels, table_of
from grip_bt.compilers.resolve import Part
from grip_bt.compilers.task_machine import TaskConcurrence, TaskMachine
from grip_bt.compilers.to_machine import CompiledMachine
from grip_bt.formats.pytrees.classes import from_document
from grip_bt.formats.pytrees.tree import Reader
from grip_bt.task import model

Row = Mapping[str, str | None]


def to_task(machine: CompiledMachine) -> model.Task:
    """Return the task of a compiled machine, with the states and edges that it has now.

    Raises:
        ImportRefusedError: it was changed into something that no task says; the error names each place.
    """
    reader = _Reader(machine)
    root = machine._resolved.root
    keys = reader.state(reader.states["/"], root, root.node)
    keys |= reader.root_edges(machine)
    reader.issues.raise_if_refused("the machine")
    task = machine.task.model_dump(by_alias=True, exclude_unset=True, exclude={"root"})
    return model.Task.model_validate({**task, "root": keys})


class _Reader:
    def __init__(self, machine: CompiledMachine):
        self.states: Mapping[str, Any] = machine.by_path
        self.behaviours = Reader(whole=True)
        self.issues = self.behaviours.issues

    def state(self, state: TaskState, part: Part, document: model.AnyNode) -> dict[str, Any]:
        """Return the keys of a state and of all below it."""
        if isinstance(state, BehaviourState):
            return self.behaviours.node(state.node, part.path)
        keys = from_document(None, document)
        if isinstance(document, model.Childless):
            return keys  # what is below a subtask stands elsewhere
        if isinstance(state, TaskConcurrence):
            names, rows, table = self._names(state, part), {}, Table()
        else:
            assert isinstance(state, TaskMachine), "these are all containers"
            names, rows, table = self._names(state, part), state._transitions, table_of(part, state.refined)
            keys |= self._initial(state, part, names, table)
        children = {}
        for label, child in names.items():
            below = self.state(self.states[child.path], child, child.node)
            said, expected = rows.get(label, {}), table.rows.get(label, {})
            if dict(said) != expected:
                below |= self._edges(part, child, said, expected)
            children[child.name] = below
        return {**keys, "child" if "child" in type(document).model_fields else "children": children}

    def _names(self, state: Any, part: Part) -> dict[str, Part]:
        """Return the label of each child that is there now, in the machine's order."""
        labels = {label: name for name, label in state_labels(part).items()}
        parts = {child.name: child for child in part.children}
        found = {}
        for label, below in state.get_children().items():
            if label in labels and below is self.states[parts[labels[label]].path]:
                found[label] = parts[labels[label]]
            elif label != AGAIN:
                self.issues.add(
                    "no-equivalent", part.path, f"the state {label!r} was added, and no node is known for it"
                )
        gone = [name for label, name in labels.items() if label not in found]
        if gone and not isinstance(part.node, model.StateMachine):
            self.issues.add("no-equivalent", part.path, f"the states {', '.join(gone)} of a {part.node.kind} are gone")  # type: ignore[union-attr]
        return found

    def _initial(self, state: TaskMachine, part: Part, names: Mapping[str, Part], table: Table) -> dict[str, Any]:
        label = state.get_initial_states()[0]
        if label == table.initial:
            return {}
        if isinstance(part.node, model.StateMachine) and label in names:
            return {"initial": names[label].name}
        self.issues.add("no-equivalent", part.path, f"it begins with {label!r} now, which its kind doesn't")
        return {}

    def _edges(self, part: Part, child: Part, said: Row, expected: Row) -> dict[str, Any]:
        """Return `on` of a child of a state machine whose edges were changed."""
        if not isinstance(part.node, model.StateMachine):
            reason = f"the transitions of {child.name!r} were changed, and a {part.node.kind} has fixed ones"  # type: ignore[union-attr]
            self.issues.add("no-equivalent", part.path, reason)
            return {}
        on = dict(child.node.on)
        for label, target in said.items():
            if target != expected.get(label):
                on[label] = str(target).partition(".")[0]
        for label in expected.keys() - said.keys():
            on.pop(label, None)
        return {"on": on}

    def root_edges(self, machine: CompiledMachine) -> dict[str, Any]:
        """Return `on` of the root, where the edges to the task's outcomes were changed."""
        (row,) = machine.machine._transitions.values()
        if dict(row) == machine.ends:
            return {}
        changed = {label: target for label, target in row.items() if machine.ends.get(label) != target}
        return {"on": {**machine.task.root.on, **changed}}
