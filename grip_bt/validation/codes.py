"""Every code that validation may report, with its severity; `docs/validation_rules.md` explains each with examples."""

from __future__ import annotations

from .issue import Severity

_ERRORS = (
    "unknown-node",
    "unknown-parameter",
    "missing-parameter",
    "wrong-parameter-type",
    "unknown-input",
    "missing-input",
    "input-given-twice",
    "unknown-subtask",
    "recursive-subtask",
    "invalid-subtask",
    "unknown-output",
    "unknown-type",
    "undeclared-variable",
    "wrong-variable-type",
    "wrong-initial-value",
    "not-a-number",
    "bad-expression",
    "wrong-expression-type",
    "read-before-write",
    "unknown-outcome",
    "contradictory-outcome",
    "unknown-child",
    "unknown-target",
    "ambiguous-target",
    "ambiguous-case",
    "missing-target",
    "misplaced-on",
    "empty-container",
    "parallel-writes",
    "parallel-read-write",
)
_WARNINGS = (
    "unknown-code",
    "unknown-message",
    "unknown-arm",
    "unknown-hand",
    "unknown-state",
    "not-taught-yet",
    "unknown-finger",
    "unknown-link",
    "unfit-project",
    "missing-package",
    "infinite-number",
    "impossible-outcome",
    "unused-outcome",
    "never-read",
    "unwritten-output",
    "shadowed-variable",
    "unreachable-node",
    "endless-machine",
    "dead-end",
)
SEVERITY: dict[str, Severity] = {
    **dict.fromkeys(_ERRORS, "error"),
    **dict.fromkeys(_WARNINGS, "warning"),
}
