"""Containers as a task has them: meanings of outcomes, rules, items; and userdata -> variables, one for each key.

SMACH copies the inputs of a nested container in and its outputs out; in the task both are one variable. Userdata is
never cleared, so the variables belong to the task and not to the containers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from grip_bt.formats.names import free
from grip_bt.formats.smach.found import Child, ContainerInfo, Value
from grip_bt.formats.smach.leaves import Leaves, Meanings
from grip_bt.nodes.smach_asking import MARK
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task import FrozenDict, Leaf, StateMachine, Variable, children_of
from grip_bt.task.model import AnyNode, Meaning


@dataclass
class Variables:
    """Values at first; `first` has those that no task can hold: the key, and the container that has it then."""

    names: dict[str, None] = field(default_factory=dict)
    values: dict[str, object] = field(default_factory=dict)
    first: dict[str, tuple[str, ContainerInfo]] = field(default_factory=dict)

    def new(self, key: str, prefix: str) -> str:
        """Return a new variable for a key of a container."""
        wanted = task_name(key)
        name = free(task_name(f"{prefix}_{key}") if wanted in self.names else wanted, self.names)
        self.names[name] = None
        return name

    def declared(self, maybe_unwritten: set[str]) -> dict[str, Variable | str]:
        """Return them as a task's `data`."""
        values = {**dict.fromkeys(maybe_unwritten), **self.values}
        return {name: Variable(type="Any", value=values[name]) if name in values else "Any" for name in self.names}


class Keys:
    """The keys of one container, as variables."""

    def __init__(self, variables: Variables, label: str, shared: Mapping[str, str] | None = None):
        self._variables, self._label, self._names = variables, label, dict(shared or {})

    def __call__(self, key: str) -> str:
        """Return a key's variable, which is made when it is asked for the first time."""
        if key not in self._names:
            self._names[key] = self._variables.new(key, self._label)
        return self._names[key]

    def begin(self, found: ContainerInfo) -> None:
        """Take over the initial values of a container's userdata."""
        for key, value in found.userdata.items():
            name = self(key)
            if name in self._variables.values or name in self._variables.first:
                continue  # the parent's value comes in
            if value.opaque is None:
                self._variables.values[name] = value.value
            else:
                self._variables.first[name] = (key, found)


def private_keys(outer: ContainerInfo, added: Child, names: Mapping[str, str]) -> set[str]:
    """Return the keys of a container in another that need variables of their own; `names`: key -> the outer variable.

    That SMACH copies shows where a key is written inside and doesn't come out, where one only comes out and has a value
    before or is written elsewhere, and where two are one outside.
    """
    found, remapping = added.state, _remapping(outer, added)
    assert isinstance(found, ContainerInfo), "states have no variables"
    beside = {*outer.input_keys, *outer.userdata, *_written(outer, but=added)}
    writes, private = _written(found), set()
    for key, variable in names.items():
        comes, goes = key in found.input_keys, key in found.output_keys
        twins = {other for other, name in names.items() if name == variable}
        apart = key in found.userdata or remapping.get(key, key) in beside if goes else key in writes
        if (apart and not (comes and goes)) or (len(twins) > 1 and writes & twins):
            private.add(key)
    return private


def _written(found: ContainerInfo, but: Child | None = None) -> set[str]:
    writes = {str(found.settings["items_label"])} if found.kind == "Iterator" else set()
    for added in found.added.values():
        if added is not but:
            writes |= {_remapping(found, added).get(key, key) for key in added.state.output_keys}
    return writes


def _remapping(found: ContainerInfo, added: Child) -> Mapping[str, str]:
    return {} if found.kind == "Iterator" else added.remapping


def mark_unwritten(node: AnyNode, missing: set[str]) -> AnyNode:
    """Tell every leaf which of its inputs may be unwritten."""
    if isinstance(node, Leaf):
        unwritten = [port for port, variable in node.in_.items() if variable in missing and port != "position"]
        return node.model_copy(update={"with_": FrozenDict({"unwritten": unwritten})}) if unwritten else node
    children = {name: mark_unwritten(child, missing) for name, child in children_of(node).items()}
    return node.model_copy(update={"children": FrozenDict(children)})


def as_machine(node: AnyNode, ends: Mapping[str, str], outcomes: Mapping[str, Meaning]) -> StateMachine:
    """Return a machine of one state, which has room for what copies; `ends`: outcome of the node -> the machine's."""
    name = free("together", outcomes)
    state = node.model_copy(update={"on": FrozenDict(dict(ends))})
    return StateMachine(kind="state_machine", initial=name, outcomes=dict(outcomes), children={name: state})


def copy_in_first(node: StateMachine, copied: Mapping[str, str], inner: Keys, leaves: Leaves) -> StateMachine:
    """Put a state first that copies keys in; `copied`: key of the container -> the parent's variable."""
    name = free("enter", {*node.children, *node.outcomes})
    step = Leaf(
        node=leaves.copy(list(copied)).manifest.id,
        in_=dict(copied),
        out={key: inner(key) for key in copied},
        on={"done": node.initial},
    )
    return node.model_copy(update={"initial": name, "children": FrozenDict({name: step, **node.children})})


def copy_out_last(node: StateMachine, out: Mapping[str, str], inner: Keys, leaves: Leaves) -> StateMachine:
    """Put a state before each outcome that copies keys out; `out`: key of the container -> the parent's variable."""
    taken = {*node.children, *node.outcomes}
    names = {outcome: free(f"leave {outcome}", taken) for outcome in node.outcomes}
    children = {
        label: child.model_copy(update={"on": FrozenDict({k: names.get(t, t) for k, t in child.on.items()})})
        for label, child in node.children.items()
    }
    used = {target for child in children.values() for target in child.on.values()}
    spec = leaves.copy(list(out))
    for outcome, name in names.items():
        if name in used:
            bound = {"in_": {key: inner(key) for key in out}, "out": dict(out)}
            children[name] = Leaf(node=spec.manifest.id, on={"done": outcome}, **bound)
    return node.model_copy(update={"children": FrozenDict(children)})


class RefusedError(Exception):
    """A container has no equivalent among the kinds of a task; the message says why."""


Rules = list[tuple[str, dict[str, str]]]


def parallel_rules(found: ContainerInfo) -> tuple[Rules, str]:
    """Return (outcome, {child: outcome}) of a Concurrence, where the first that holds decides, and its outcome else."""
    settings = found.settings
    for name in ("child_termination_cb", "outcome_cb"):
        if settings.get(name):
            raise RefusedError(f"its `{name}` decides in its own way when it ends or how")
    entries: dict[str, dict[str, str]] = settings["outcome_map"]
    if not all(entries.values()):
        raise RefusedError("an entry of its outcome map is empty")
    for wanted in entries.values():
        if unknown := sorted(set(wanted) - set(found.added)):
            raise RefusedError(f"its outcome map names {unknown}, which it doesn't hold")
    writers: dict[str, str] = {}
    for label, added in found.added.items():
        for key in added.state.output_keys:
            there = added.remapping.get(key, key)
            if there in writers and writers[there] != label:
                raise RefusedError(f"{writers[there]!r} and {label!r} both write the userdata `{there}`")
            writers[there] = label
    return sorted(entries.items(), key=lambda entry: -len(entry[1])), settings["default_outcome"]


@dataclass(frozen=True)
class Iteration:
    """What an Iterator does after outcomes of the contained state: the next item comes, or it ends with an outcome.

    `label` is the userdata that holds the item; `interrupted`: what it ends with when preempted in an item, not always
    one of its own outcomes, and after which of its state's.
    """

    items: list[Any]
    label: str
    final: dict[str, str]
    exhausted: str
    interrupted: dict[str, list[str]]


def iteration_of(found: ContainerInfo) -> Iteration:
    """Return what an Iterator does; refuse one of which it isn't known, or that leads nowhere."""
    settings = found.settings
    if len(found.added) != 1:
        raise RefusedError("it needs exactly one contained state")
    (added,) = found.added.values()
    given = found.items or Value(value=[])
    if given.opaque is not None:
        raise RefusedError(f"its items are `{given.opaque}`, known only at run time")
    if not isinstance(items := given.value, list):
        raise RefusedError("its items aren't a list")
    loop, leave, mapped = settings["loop_outcomes"], settings["break_outcomes"], settings["final_outcome_map"]
    exhausted = settings["exhausted_outcome"]
    known = added.state.outcomes
    # upstream's rule: with a break list, the rest loops; without, whatever isn't in the loop list breaks
    loops = sorted({o for o in known if (o not in leave if leave else o in loop)})
    final = {o: mapped.get(o, o) for o in known if o not in loops}
    for target in (*final.values(), mapped.get(exhausted, exhausted)):
        if target not in (found.outcomes or ()):
            raise RefusedError(f"it would end with {target!r}, which is none of its outcomes")
    interrupted: dict[str, list[str]] = {}
    for outcome in loops:
        interrupted.setdefault(mapped.get(outcome, outcome), []).append(outcome)
    return Iteration(items, settings["items_label"], final, mapped.get(exhausted, exhausted), interrupted)


def check(found: ContainerInfo) -> None:
    """Refuse what wasn't read well enough, and what SMACH would refuse too."""
    if failed := [issue for issue in found.issues if issue.severity == "error"]:
        raise RefusedError(failed[0].message)
    if found.parent is not None and (names := found.settings.get("overridden")):
        raise RefusedError(f"its class has a `{names[0]}` of its own")
    if asked := found.settings.get("asked"):
        raise RefusedError(f"the items of an Iterator in it are taken from its userdata, {asked[0]!r}")
    if not found.outcomes:
        raise RefusedError("its outcomes aren't known")
    if not found.added:
        raise RefusedError("nothing is added to it")
    for label, added in found.added.items():
        if added.constants:
            raise RefusedError(f"{label!r} has constants, which SMACH writes before each execution")
        known = added.state.outcomes
        if known and (wrong := sorted(set(added.transitions) - set(known))):
            raise RefusedError(f"{label!r} has transitions for {wrong}, but {added.state.cls} ends with {known}")
    if found.kind in ("StateMachine", "Sequence") and found.initial not in found.added:
        raise RefusedError(f"its initial state {found.initial!r} isn't there")


def meanings(found: ContainerInfo, means_by_name: Meanings) -> dict[str, Meaning]:
    """Return outcome, as a task spells it -> what it means; refuse one called `success` that would mean the other."""
    means = {task_name(o): meaning for o, meaning in means_by_name.of(found.outcomes or ()).items()}
    if wrong := [o for o in ("success", "failure") if o in means and means[o] != o]:
        raise RefusedError(f"its outcome {wrong[0]!r} would have to mean the opposite")
    return means


def labelled(found: ContainerInfo, default: str, means_by_name: Meanings) -> tuple[dict[str, Meaning], dict[str, str]]:
    """Return the outcomes that a parallel declares, and what each outcome is called: one `success`, one `failure`."""
    meanings(found, means_by_name)
    outcomes = list(dict.fromkeys((default, *(found.outcomes or ()))))
    means = means_by_name.of(outcomes)
    labels: dict[str, str] = {o: o for o in outcomes if o in ("success", "failure")}
    for outcome in outcomes:
        if outcome not in labels and means[outcome] not in labels.values():
            labels[outcome] = means[outcome]
    own = {o: task_name(o) for o in outcomes if o not in labels}
    return {name: means[o] for o, name in own.items()}, {**labels, **own}


def source_of(found: ContainerInfo) -> dict[str, object]:
    """Return the marks of a container: where it comes from, and what it was."""
    return {"x-source": str(found.span), MARK: found.kind}
