"""Looking into a compiled task from outside, while it runs: its nodes, and conditions over its variables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from grip_bt.base.errors import ExpressionError, UnknownNameError
from grip_bt.base.expression import parse_expression
from grip_bt.compilers.binding import bind_condition

from .resolve import Part

if TYPE_CHECKING:
    from .to_machine import CompiledMachine
    from .to_tree import CompiledTree


def parts_of(compiled: CompiledTree | CompiledMachine) -> Mapping[str, Part]:
    """Return every node of a compiled task by path, in document order."""
    return {part.path: part for part in compiled._resolved.root.walk()}


def probe(compiled: CompiledTree | CompiledMachine, part: Part, text: str) -> Callable[[], bool]:
    """Return what computes a condition over the variables that a node sees.

    Raises:
        ExpressionError: the text isn't a condition.
        UnknownNameError: it names a variable that isn't declared there or above.
    """
    if not text.strip():
        raise ExpressionError(text, "a condition is missing, such as `count > 3`")
    for name in parse_expression(text).names:
        if part.scope.find(name) is None:
            raise UnknownNameError("variable", name, part.scope.visible(), f"`{text}` at {part.path}")
    return bind_condition(part.path, "if", text, part.scope, compiled.data).holds
