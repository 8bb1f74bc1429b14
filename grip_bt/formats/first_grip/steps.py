"""What a state of the first GRIP becomes, step by step, and what it stands in."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from .original import Note, OriginalState
from .words import key_of, name_of

STORES = {
    "joint state": ("joint_states", "JointState"),
    "pose": ("poses", "Pose"),
    "trajectory": ("trajectories", "Trajectory"),
    "plan": ("plans", "Plan"),
}
PLAIN = {"success": "success", "failure": "failure"}
"""Ends of most states."""


@dataclass
class Made:
    """A state as a node.

    Attributes:
        node: the node's keys.
        ends: outcome of the state -> outcome of the node; those that can't happen are left out.
    """

    node: dict[str, Any]
    ends: dict[str, str]


@dataclass
class Setting:
    """What a task's states stand in, and what they need.

    Attributes:
        arms: group of MoveIt -> arm or hand of the project.
        sensors: name of a sensor -> its key in the project.
        components: name of a component -> (its key, how many outcomes it has).
        messages: names that the project's stores hold, by store.
        produced: userdata that some state writes.
        variables: variables of the task, with their types.
        unknown: states without an equal, by the name of their node.
        notes: what isn't as it was.
    """

    arms: Mapping[str, str] = field(default_factory=dict)
    sensors: Mapping[str, str] = field(default_factory=dict)
    components: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    messages: Mapping[str, Collection[str]] = field(default_factory=dict)
    produced: set[str] = field(default_factory=set)
    variables: dict[str, Any] = field(default_factory=dict)
    unknown: dict[str, OriginalState] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)

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


class Steps:
    """What one state does, step by step."""

    def __init__(self, state: OriginalState, setting: Setting, place: str):
        self.state, self.setting, self.place = state, setting, place
        self.steps: dict[str, dict[str, Any]] = {}

    def slot(self, name: str) -> str:
        """Return what a field holds, as text."""
        value = self.state.slots.get(name)
        return "" if value is None else str(value).strip().strip("\"'")

    def note(self, kind: Any, text: str) -> None:
        """Tell what isn't as it was."""
        self.setting.notes.append(Note(kind, self.place, text))

    def add(self, step: str, node: str, **keys: Mapping[str, Any]) -> None:
        """Add a step; empty keys are left out."""
        name = name_of(step, self.steps)
        said = {{"in_": "in", "with_": "with"}.get(key, key): dict(value) for key, value in keys.items() if value}
        self.steps[name] = {"node": node, **said}

    def value(self, name: str, kind: str, what: str) -> str:
        """Return the variable of a value, which may have to be got from a store first."""
        store, type_name = STORES.get(kind, ("", "Any"))
        if not store and name_of(name) not in self.setting.produced:
            found = [(s, t) for s, t in STORES.values() if name in self.setting.messages.get(s, ())]
            store, type_name = found[0] if found else ("", "Any")
            if not found:
                self.note("missing", f"{what} {name!r} is written by no state and is no named message: give it a value")
        if not store:
            return self.setting.variable(name)
        known = self.setting.messages.get(store)
        if known is not None and name not in known and store != "plans":
            self.note("missing", f"there is no {kind or 'message'} {name!r} in messages/{store}.yaml")
        variable = self.setting.variable(f"{name} {type_name}".replace(" ", "_"), type_name)
        self.add(f"get_{key_of(name)}", "messages/get", with_={"store": store, "name": name}, out={"value": variable})
        return variable

    def produced(self, name: str) -> str:
        """Return the variable that some state writes under a name; empty where none does."""
        return self.setting.variable(name) if name_of(name) in self.setting.produced else ""

    def node(self) -> dict[str, Any]:
        """Return one step as it is, several in a sequence."""
        if len(self.steps) == 1:
            return next(iter(self.steps.values()))
        return {"kind": "sequence", "children": self.steps}
