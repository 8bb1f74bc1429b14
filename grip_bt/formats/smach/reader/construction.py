"""What smach's constructors and methods do, in terms of what is found."""

from __future__ import annotations

from typing import Any, Protocol

from .evaluation import use_default
from .found import CONTAINERS, FIXED_OUTCOMES, Child, ContainerInfo, Reference, Span, StateInfo, Unresolved
from .names import Function, is_literal

# Positional parameters of upstream's constructors.
PARAMETERS = {
    "State": ("outcomes", "input_keys", "output_keys", "io_keys"),
    "CBState": ("cb", "cb_args", "cb_kwargs", "outcomes", "input_keys", "output_keys", "io_keys"),
    "StateMachine": ("outcomes", "input_keys", "output_keys"),
    "Sequence": ("outcomes", "connector_outcome", "input_keys", "output_keys"),
    "Concurrence": (
        *("outcomes", "default_outcome", "input_keys", "output_keys"),
        *("outcome_map", "outcome_cb", "child_termination_cb"),
    ),
    "Iterator": ("outcomes", "input_keys", "output_keys", "it", "it_label", "exhausted_outcome"),
    "ConditionState": ("cond_cb", "input_keys"),
    "MonitorState": ("topic", "msg_type", "cond_cb", "max_checks", "input_keys", "output_keys"),
}
_ADD = {
    "add": ("label", "state", "transitions", "remapping", "constants"),
    "add_auto": ("label", "state", "connector_outcomes", "transitions", "remapping", "constants"),
    "set_contained_state": ("label", "state", "loop_outcomes", "break_outcomes", "final_outcome_map"),
}
_KEYS = {
    "register_outcomes": ("outcomes",),
    "register_input_keys": ("input_keys",),
    "register_output_keys": ("output_keys",),
    "register_io_keys": ("input_keys", "output_keys"),
}


class Reading(Protocol):
    """What a reader knows of the moment at which something is done to a container; see `calls.Calls`."""

    open: list[ContainerInfo]
    running: list[Function]
    conditions: list[tuple[str, bool]]
    in_main: bool

    def doubtful(self, container: ContainerInfo, what: str, span: Span) -> None:
        """Note that what happens to a container hangs on what is known only at run time."""


def initialise(reader: Reading, found: StateInfo, kind: str, arguments: list[object], named: dict[str, object]) -> None:
    """Do what the constructor of a class of smach does."""
    found.initialised = True
    given = dict(zip(PARAMETERS.get(kind, ()), arguments, strict=False)) | named
    declared = _words(found, "outcomes", given.get("outcomes", []))
    if kind in FIXED_OUTCOMES:
        declared = [*FIXED_OUTCOMES[kind], *(declared or ())]
    found.outcomes = declared
    both = _words(found, "io_keys", given.get("io_keys", [])) or []
    found.input_keys = [*(_words(found, "input_keys", given.get("input_keys", [])) or []), *both]
    found.output_keys = [*(_words(found, "output_keys", given.get("output_keys", [])) or []), *both]
    for name in ("cb", "cond_cb", "goal_cb", "result_cb", "request_cb", "response_cb"):
        if name in given:
            _interface(found, name, given[name])
    _ros_keys(found, kind, given)
    if isinstance(found, ContainerInfo):
        found.settings = given
        if kind == "Iterator" and found.outcomes is not None:
            exhausted = given.get("exhausted_outcome", "exhausted")
            if isinstance(exhausted, str):
                _add_words(found.outcomes, [exhausted])
        reader.doubtful(found, "the container is made", found.span)
    for name in ("outcomes", "input_keys", "output_keys"):
        words = getattr(found, name)
        if words is not None:
            setattr(found, name, list(dict.fromkeys(words)))


def _words(found: StateInfo, name: str, value: object) -> list[str] | None:
    """Return the words of a list; None, with a note, where they are known only at run time."""
    value = use_default(value, lambda told: found.problem("partial", f"the {name} of {found.cls}: {told}"))
    if isinstance(value, str):
        value = list(value)  # upstream takes a text for its characters
    if isinstance(value, (list, tuple, set)) and all(isinstance(w, str) for w in value):
        return list(value)
    if value is None and name != "outcomes":
        return []
    text = value.text if isinstance(value, Unresolved) else str(value)
    found.problem("partial", f"the {name} of {found.cls} are `{text}`, known only at run time")
    return None


def _interface(found: StateInfo, name: str, callback: object) -> None:
    """Add what `cb_interface` declares on a callback."""
    held = callback.interface if isinstance(callback, Function) else None
    if held is None:
        return
    words = {k: _words(found, k, held.get(k, [])) or [] for k in ("outcomes", "input_keys", "output_keys")}
    if name in ("cb", "result_cb", "response_cb") and found.outcomes is not None:
        _add_words(found.outcomes, words["outcomes"])
    _add_words(found.input_keys, words["input_keys"])
    _add_words(found.output_keys, words["output_keys"])


def _ros_keys(found: StateInfo, kind: str, given: dict[str, Any]) -> None:
    """Add the keys that ROS states read goals and requests from, and write results and responses to."""
    sides = (("goal", "request", found.input_keys), ("result", "response", found.output_keys))
    for action, service, keys in sides if kind in ("SimpleActionState", "ServiceState") else ():
        side = action if kind == "SimpleActionState" else service
        if isinstance(given.get(f"{side}_key"), str):
            _add_words(keys, [given[f"{side}_key"]])
        _add_words(keys, _words(found, f"{side}_slots", given.get(f"{side}_slots", [])) or [])


def _add_words(there: list[str], more: list[str]) -> None:
    there.extend(w for w in more if w not in there)


def call(
    reader: Reading,
    kind: str,
    name: str,
    me: StateInfo | None,
    arguments: list[object],
    named: dict[str, object],
    span: Span,
) -> object:
    """Do what a method of a state or container does."""
    if name in _ADD and kind in CONTAINERS:
        given = dict(zip(_ADD[name], arguments, strict=False)) | named
        return _add(reader, kind, name, me, given, span)
    if me is None:
        return NotImplemented
    if name in _KEYS and arguments:
        for attribute in _KEYS[name]:
            words = _words(me, attribute, arguments[0])
            there = getattr(me, attribute)
            if words is not None and there is not None:
                _add_words(there, words)
        return None
    if name in ("get_registered_outcomes", "get_registered_input_keys", "get_registered_output_keys"):
        return tuple(getattr(me, name.removeprefix("get_registered_")) or ())
    if not isinstance(me, ContainerInfo):
        return NotImplemented
    if name == "opened":
        return me
    if name == "open":
        reader.open.append(me)
    elif name == "close":
        reader.open = [each for each in reader.open if each is not me]
    elif name == "execute":
        me.executed_in.extend(reader.running)
        if not (reader.running or reader.conditions or reader.in_main):
            me.attributes.setdefault("<executed>", span)
    elif name == "set_initial_state" and arguments and isinstance(arguments[0], (list, tuple)) and arguments[0]:
        me.initial = arguments[0][0] if isinstance(arguments[0][0], str) else me.initial
    elif name == "set_iteritems":
        me.settings.update(zip(("it", "it_label"), arguments, strict=False))
        me.settings.update(named)
    else:
        return NotImplemented
    return None


def _add(reader: Reading, kind: str, name: str, me: StateInfo | None, given: dict[str, Any], span: Span) -> Any:
    container = reader.open[-1] if reader.open else me
    state = given.get("state")
    if not isinstance(container, ContainerInfo):
        return state  # added to a container that is passed from elsewhere: whoever passes it is read
    label = use_default(given.get("label"), lambda told: container.problem("partial", f"a label: {told}", span))
    found = _state_of(state, span)
    if not isinstance(label, str):
        text = label.text if isinstance(label, Unresolved) else str(label)
        container.problem("failed", f"the label `{text}` of a state is known only at run time", span)
        return state
    if label in container.added:
        if container.added[label].state is not found and container.kind != "Concurrence":
            container.problem("partial", f"{label!r} is added twice; the first one counts", span)
            return state
    reader.doubtful(container, f"state {label!r} is added", span)
    if found.parent is None:
        found.parent = container
    else:  # source that makes it would make two of it
        found.expression, found.why = None, f"one object of {found.cls} is added in two places"
    if name == "set_contained_state":
        container.settings.update(given)
    added = Child(
        label,
        found,
        _mapping(container, f"the transitions of {label!r}", given.get("transitions"), span),
        _mapping(container, f"the remapping of {label!r}", given.get("remapping"), span),
        span,
        constants=_constants(container, label, given.get("constants"), span),
    )
    if kind == "Sequence" or container.kind == "Sequence":
        connector = container.settings.get("connector_outcome")
        added.connectors = (connector,) if kind == "Sequence" and isinstance(connector, str) else ()
    elif name == "add_auto":
        added.connectors = tuple(_words(container, "connector_outcomes", given.get("connector_outcomes", [])) or ())
    _connect(container, added)
    container.added[label] = added
    if container.initial is None:
        container.initial = label
    return state


def _connect(container: ContainerInfo, added: Child) -> None:
    """Let the connector outcomes of the state before lead here."""
    if not container.added:
        return
    before = next(reversed(container.added.values()))
    for outcome in before.connectors:
        if container.kind != "Sequence" or before.transitions.get(outcome) is None:
            before.transitions[outcome] = added.label


def _state_of(value: object, span: Span) -> StateInfo:
    if isinstance(value, StateInfo):
        return value
    if isinstance(value, Reference):
        return StateInfo("", value.name.split(".")[-1], span, value.expression)
    text = value.text if isinstance(value, Unresolved) else "?"
    expression = value.expression if isinstance(value, Unresolved) else None
    name = text.split("(")[0].split(".")[-1]
    cls = name if name.isidentifier() else "State"
    made = StateInfo("", cls, span, expression, span.file, f"`{text}` is known only at run time")
    made.problem("partial", f"nothing is known of `{text}`; its outcomes are taken from its transitions")
    return made


def _constants(container: ContainerInfo, label: str, value: object, span: Span) -> dict[str, object]:
    if not value:
        return {}
    if isinstance(value, dict) and all(isinstance(key, str) for key in value):
        return dict(value)
    container.problem(
        "partial", f"which constants {label!r} has is known only at run time; set them in the userdata", span
    )
    return {}


def _mapping(container: ContainerInfo, what: str, value: object, span: Span) -> dict[str, Any]:
    if value is None or value == []:
        return {}

    def note(told: str) -> None:
        container.problem("partial", f"{what}: {told}", span)

    value = use_default(value, note)
    if isinstance(value, dict):
        value = {use_default(key, note): use_default(target, note) for key, target in value.items()}
        if all(isinstance(k, str) and (v is None or isinstance(v, str)) for k, v in value.items()):
            return dict(value)
        for key, target in value.items():
            if not (isinstance(key, str) and (target is None or isinstance(target, str))):
                shown = [x.text if isinstance(x, Unresolved) else repr(x) for x in (key, target)]
                container.problem("failed", f"{what}: `{shown[0]}: {shown[1]}` is known only at run time", span)
        return {k: v for k, v in value.items() if is_literal(k) and is_literal(v)}
    text = value.text if isinstance(value, Unresolved) else repr(value)
    container.problem("failed", f"{what} are `{text}`, known only at run time", span)
    return {}
