"""The codes of issues with their severities, and words that several rules share."""

from __future__ import annotations

from grip_bt.base.issue import Severity
from grip_bt.base.types import BUILTINS
from grip_bt.task.catalog import Type

_STRUCTURAL = (
    *("unknown-node", "unknown-parameter", "missing-parameter", "unknown-input", "missing-input", "unknown-output"),
    *("unknown-subtask", "recursive-subtask", "invalid-subtask", "unlisted-code", "bad-expression"),
    *("unknown-type", "undeclared-variable", "unknown-outcome", "contradictory-outcome", "unknown-child"),
    *("unknown-target", "missing-target", "misplaced-on"),
)
_ERRORS = (
    *_STRUCTURAL,
    *("wrong-parameter-type", "input-given-twice", "wrong-variable-type", "unknown-behaviour", "wrong-initial-value"),
    *("not-a-number", "wrong-expression-type", "read-before-write", "ambiguous-target", "ambiguous-case"),
    *("empty-container", "parallel-writes", "parallel-read-write", "unknown-code", "unknown-arm", "unknown-hand"),
    *("unknown-state", "unknown-finger", "unknown-link", "unfit-project"),
)
_WARNINGS = (
    *("unknown-message", "not-taught-yet", "no-controller", "missing-package", "infinite-number"),
    *("impossible-outcome", "unused-outcome", "never-read", "unwritten-output", "shadowed-variable"),
    *("unreachable-node", "endless-machine", "dead-end"),
)
SEVERITY: dict[str, Severity] = {**dict.fromkeys(_ERRORS, "error"), **dict.fromkeys(_WARNINGS, "warning")}
STRUCTURAL = frozenset(_STRUCTURAL)
"""Errors with which a task can't be compiled; with the others it could, and would do what isn't meant."""

_WRITTEN = frozenset({*BUILTINS, "list", "dict", "Any", "None", "Pose"}) - {"bytes"}
"""Types of which a task file can write a value; a pose as `{position: [x, y, z], quaternion: [w, x, y, z]}`."""


def has_literal_form(type_: Type) -> bool:
    """Tell whether a task file can write a value of a type; what it can't is made by nodes."""
    return type_.name in _WRITTEN


def suggestion(hint: str, otherwise: str) -> str:
    """Return a fix: the word that `grip_bt.base.errors.nearest` has found, or `otherwise` when it found none."""
    return f"write {hint.split(chr(39))[1]!r}" if hint else otherwise
