"""Commands in a few words, for a history that people read."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import commands as c

LONGEST = 80
"""Characters of a title; longer ones are cut."""
SHOWN = 3
"""So many names of several are said; the others are counted."""

_KINDS = {"for_each": "for each", "state_machine": "state machine"}
_KEYS: dict[tuple[str, ...], str] = {
    ("doc",): "documentation",
    ("with",): "parameters",
    ("in",): "inputs",
    ("out",): "outputs",
}
_FORMS = {"bt": "composites", "sm": "state machines"}


def title_of(command: c.AnyCommand) -> str:
    """Return a command in a few words, such as `rename look to see`."""
    title = " ".join(_WORDS[type(command)](command).split())
    return title if len(title) <= LONGEST else f"{title[: LONGEST - 3]}..."


def _node(path: str) -> str:
    return {"": "the task", "/": "the root"}.get(path, path)


def _nodes(paths: tuple[str, ...]) -> str:
    shown = ", ".join(_node(path) for path in paths[:SHOWN])
    return shown if len(paths) <= SHOWN else f"{shown} and {len(paths) - SHOWN} more"


def _kind(kind: str) -> str:
    words = _KINDS.get(kind, kind)
    return f"an {words}" if words[:1] in "aeiou" else f"a {words}"


def _key(command: c.Set | c.Unset) -> str:
    key = command.key[1:] if command.key[0] == "with" and len(command.key) > 1 else command.key
    return f"{_KEYS.get(key, '/'.join(key))} of {_node(command.path)}"


def _value(value: Any) -> str:
    """Return a short value in words; empty for one that is no word."""
    if isinstance(value, bool):
        return " to yes" if value else " to no"
    if isinstance(value, int | float | str) and 0 < len(str(value)) <= 20:
        return f" to {value}"
    return ""


def _move(command: c.Move) -> str:
    above = command.path.rpartition("/")[0] or "/"
    if above == command.parent:
        return f"move {command.path} among its neighbours"
    return f"move {command.path} into {_node(command.parent)}"


def _bind(command: c.Bind) -> str:
    verb = "reads" if command.side == "in" else "writes"
    return f"{command.port} of {_node(command.path)} {verb} {command.variable}"


def _unbind(command: c.Unbind) -> str:
    verb = "reads" if command.side == "in" else "writes"
    return f"{command.port} of {_node(command.path)} {verb} no variable"


def _set_meaning(command: c.SetMeaning) -> str:
    means = command.meaning or "what its manifest says"
    return f"{command.outcome} of {_node(command.path)} means {means}"


def _group(command: c.Group) -> str:
    if command.title or not command.commands:
        return command.title or "change nothing"
    first, more = title_of(command.commands[0]), len(command.commands) - 1
    return f"{first} and {more} more" if more else first


def _patch(command: c.Patch) -> str:
    return command.title or "take an edit back"


_WORDS: dict[type[Any], Callable[[Any], str]] = {
    c.Add: lambda it: f"add {it.name} to {_node(it.parent)}",
    c.Paste: lambda it: f"paste {it.name or it.clip.name} into {_node(it.parent)}",
    c.Remove: lambda it: f"remove {_node(it.path)}",
    c.Move: _move,
    c.Rename: lambda it: f"rename {_node(it.path)} to {it.name}",
    c.Set: lambda it: f"set {_key(it)}{_value(it.value)}",
    c.Unset: lambda it: f"take away {_key(it)}",
    c.Comment: lambda it: f"comment on {_node(it.path)}" if it.text.strip() else f"no comment on {_node(it.path)}",
    c.Connect: lambda it: f"lead {it.outcome} of {_node(it.path)} to {it.target}",
    c.Disconnect: lambda it: f"lead {it.outcome} of {_node(it.path)} nowhere",
    c.Wrap: lambda it: f"wrap {_nodes(it.paths)} in {_kind(it.kind)}",
    c.Unwrap: lambda it: f"unwrap {_node(it.path)}",
    c.ChangeKind: lambda it: f"make {_node(it.path)} {_kind(it.kind)}",
    c.Convert: lambda it: f"convert {_node(it.path)} to {_FORMS[it.to]}",
    c.Extract: lambda it: f"extract {_node(it.path)} to {it.file}",
    c.Inline: lambda it: f"inline {_node(it.path)}",
    c.Bind: _bind,
    c.Unbind: _unbind,
    c.SetMeaning: _set_meaning,
    c.Declare: lambda it: f"declare {it.name} in {_node(it.path)}",
    c.Undeclare: lambda it: f"remove the variable {it.name} of {_node(it.path)}",
    c.RenameVariable: lambda it: f"rename the variable {it.name} to {it.to}",
    c.RenameOutcome: lambda it: f"rename the outcome {it.outcome} of {_node(it.path)} to {it.to}",
    c.Group: _group,
    c.Patch: _patch,
}
