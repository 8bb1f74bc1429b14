"""Userdata -> variables: each key of each container is a variable of the task.

SMACH copies the inputs of a nested container in and its outputs out; in the task both are one variable. Userdata is
never cleared, so the variables belong to the task and not to the containers.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from grip_bt.formats.names import free
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task import FrozenDict, Leaf, StateMachine, Variable, children_of
from grip_bt.task.model import AnyNode, Meaning

from .found import ContainerInfo, Value
from .leaves import Leaves

_LARGEST = 2**63


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
        made: dict[str, Variable | str] = {}
        for name in self.names:
            if name in self.values:
                made[name] = Variable(type="Any", value=self.values[name])
            elif name in maybe_unwritten:
                made[name] = Variable(type="Any", value=None)
            else:
                made[name] = "Any"
        return made


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
            try:
                self._variables.values[name] = plain_literal(value)
            except ValueError:
                self._variables.first[name] = (key, found)


def plain_literal(value: Value) -> object:
    """Return a value as a task can hold it, or raise ValueError with its source."""
    if value.opaque is not None:
        raise ValueError(value.opaque)
    todo: list[object] = [value.value]
    while todo:
        each = todo.pop()
        if isinstance(each, int) and abs(each) >= _LARGEST:
            raise ValueError(repr(each))
        todo += each if isinstance(each, list) else each.values() if isinstance(each, dict) else ()
    return value.value


@dataclass
class VariableSharing:
    """Who writes which variable, and which keys of nested containers are variables of their parents.

    `chain`: the containers around what is being made, as `writes` has them with the variables that a leaf writes.
    """

    chain: list[ContainerInfo] = field(default_factory=list)
    writes: list[tuple[tuple[ContainerInfo, ...], set[str]]] = field(default_factory=list)
    shared: list[tuple[ContainerInfo, Mapping[str, str]]] = field(default_factory=list)

    def wrote(self, variables: set[str]) -> None:
        """Note what a leaf of the innermost container writes."""
        self.writes.append((tuple(self.chain), variables))

    def wrote_outside(self, variables: set[str]) -> None:
        """Note what the innermost container writes as a whole."""
        self.writes.append((tuple(self.chain[:-1]), variables))

    def check(self, initial: set[str]) -> None:
        """Note a problem for each key whose copies make a difference; `initial` variables have a value at first."""
        for found, key, text, _ in self._conflicts(initial):
            found.problem("partial", f"userdata `{key}` {text}")

    def copied_out(self, initial: set[str]) -> set[tuple[ContainerInfo, str]]:
        """Return the keys of containers that need a variable of their own, copied out at the end."""
        return {(found, key) for found, key, _, out in self._conflicts(initial) if out}

    def _conflicts(self, initial: set[str]) -> Iterator[tuple[ContainerInfo, str, str, bool]]:
        """Yield container, key, what is wrong, and whether a variable of its own needs_copy it."""
        for found, names in self.shared:
            reads, writes = _inside(found)
            for key, variable in names.items():
                conflict = self._conflict(found, key, variable, reads, writes, initial)
                twins = sorted(k for k, v in names.items() if v == variable)
                if not conflict and len(twins) > 1 and writes & set(twins):
                    conflict = f"and {[k for k in twins if k != key]} are one key of the parent: SMACH keeps them apart"
                if conflict:
                    needs_copy = len(twins) > 1 or (key in found.output_keys and key not in found.input_keys)
                    yield found, key, f"{conflict}; the task has one shared variable, `{variable}`", needs_copy

    def _conflict(
        self, found: ContainerInfo, key: str, variable: str, reads: set[str], writes: set[str], initial: set[str]
    ) -> str:
        comes, goes = key in found.input_keys, key in found.output_keys
        if comes and not goes and key in writes:
            return f"is an input but no output, and a state writes it: SMACH discards that when the {found.kind} ends"
        if goes and not comes:
            others = any(found not in chain and variable in written for chain, written in self.writes)
            if others:
                return f"is an output but no input, and is written elsewhere: SMACH keeps the {found.kind}'s own value"
            if key in reads and variable in initial:
                return f"is an output but no input, and a state reads it: SMACH shows what the {found.kind} has written"
        return ""


def copied_in(found: ContainerInfo) -> list[str]:
    """Return the keys of a machine that need a variable of their own: they come in and not out, and are written."""
    writes = _inside(found)[1]
    return [key for key in found.input_keys if key in writes and key not in found.output_keys]


def _inside(found: ContainerInfo) -> tuple[set[str], set[str]]:
    reads: set[str] = set()
    writes: set[str] = set()
    for added in found.added.values():
        remapping = {} if found.kind == "Iterator" else added.remapping
        reads |= {remapping.get(key, key) for key in added.state.input_keys}
        writes |= {remapping.get(key, key) for key in added.state.output_keys}
    if found.kind == "Iterator":
        writes.add(str(found.settings.get("it_label", "it_data")))
    return reads, writes


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
