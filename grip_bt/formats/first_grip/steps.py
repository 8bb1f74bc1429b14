"""What a state of the first GRIP becomes, step by step, and what it stands in."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from grip_bt.formats.imported import Issues
from grip_bt.formats.names import key_of

from .original import GripState
from .words import name_of

STORES = {
    "joint state": ("joint_states", "JointState"),
    "pose": ("poses", "Pose"),
    "trajectory": ("trajectories", "Trajectory"),
    "plan": ("plans", "Plan"),
}
PLAIN = {"success": "success", "failure": "failure"}
"""Ends of most states."""


@dataclass
class ConvertedState:
    """A state as a node.

    Attributes:
        node: the node's keys.
        ends: outcome of the state -> outcome of the node; those that can't happen are left out.
    """

    node: dict[str, Any]
    ends: dict[str, str]


@dataclass
class ImportContext:
    """What a task's states stand in, and what they need.

    Attributes:
        arms: group of MoveIt -> arm or hand of the project.
        sensors: name of a sensor -> its key in the project.
        components: name of a component -> (its key, how many outcomes it has).
        messages: names that the project's stores hold, by store.
        produced: userdata that some state writes.
        variables: variables of the task, with their types.
        unknown: states without an equal, by the name of their node.
        issues: what isn't as it was.
    """

    arms: Mapping[str, str] = field(default_factory=dict)
    sensors: Mapping[str, str] = field(default_factory=dict)
    components: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    messages: Mapping[str, Collection[str]] = field(default_factory=dict)
    produced: set[str] = field(default_factory=set)
    variables: dict[str, Any] = field(default_factory=dict)
    unknown: dict[str, GripState] = field(default_factory=dict)
    issues: Issues = field(default_factory=Issues)

    def variable(self, name: str, type_name: str = "Any") -> str:
        """Return the variable of a name; it holds anything where it is written as more than one type."""
        name = name_of(name)
        self.variables[name] = type_name if self.variables.get(name, type_name) == type_name else "Any"
        return name

    def arm(self, group: object) -> dict[str, str]:
        """Return the parameter that names an arm; none where the project has one only."""
        text = str(group or "")
        if not text:
            return {}
        return {"arm": self.arms.get(text, key_of(text))}


class StepBuilder:
    """What one state does, step by step."""

    def __init__(self, state: GripState, context: ImportContext, place: str):
        self.state, self.context, self.place = state, context, place
        self.steps: dict[str, dict[str, Any]] = {}

    def slot(self, name: str) -> str:
        """Return what a field holds, as text."""
        value = self.state.slots.get(name)
        return "" if value is None else str(value).strip().strip("\"'")

    def note(self, code: str, text: str) -> None:
        """Tell what isn't as it was."""
        self.context.issues.add(code, self.place, text)

    def add(self, step: str, node: str, **keys: Mapping[str, Any]) -> None:
        """Add a step; empty keys are left out."""
        name = name_of(step, self.steps)
        said = {{"in_": "in", "with_": "with"}.get(key, key): dict(value) for key, value in keys.items() if value}
        self.steps[name] = {"node": node, **said}

    def value(self, name: str, kind: str, what: str) -> str:
        """Return the variable of a value, which may have to be got from a store first."""
        store, type_name = STORES.get(kind, ("", "Any"))
        if not store and name_of(name) not in self.context.produced:
            found = [(s, t) for s, t in STORES.values() if name in self.context.messages.get(s, ())]
            store, type_name = found[0] if found else ("", "Any")
            if not found:
                self.note(
                    "incomplete", f"{what} {name!r} is neither written by a state nor a stored message; give it a value"
                )
        if not store:
            return self.context.variable(name)
        known = self.context.messages.get(store)
        if known is not None and name not in known and store != "plans":
            self.note("incomplete", f"there is no {kind or 'message'} {name!r} in messages/{store}.yaml")
        variable = self.context.variable(f"{name} {type_name}".replace(" ", "_"), type_name)
        self.add(f"get_{key_of(name)}", "messages/get", with_={"store": store, "name": name}, out={"value": variable})
        return variable

    def produced(self, name: str) -> str:
        """Return the variable that some state writes under a name; empty where none does."""
        return self.context.variable(name) if name_of(name) in self.context.produced else ""

    def node(self) -> dict[str, Any]:
        """Return one step as it is, several in a sequence."""
        if len(self.steps) == 1:
            return next(iter(self.steps.values()))
        return {"kind": "sequence", "children": self.steps}
