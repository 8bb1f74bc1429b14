"""`$(...)` of launch files: variables, the environment, packages, folders, and simple logic. Nothing is executed."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from grip_bt.base.errors import DocumentError, EvaluationError, ExpressionError, listing, nearest
from grip_bt.base.evaluation import value_of
from grip_bt.base.expression import parse_expression
from grip_bt.ros.interfaces.packages import PackageError, executable_of, share_of

from .element import LaunchError

TRUE, FALSE = ("true", "1"), ("false", "0")
MOST = 100
"""Substitutions in one text, also within each other."""
_QUOTED = re.compile(r"""(['"])((?:\\.|(?!\1).)*)\1""", re.DOTALL)


@dataclass
class LaunchContext:
    """Where a text stands, and what its substitutions see."""

    source: Path
    line: int
    variables: Mapping[str, str]
    env: Mapping[str, str]

    def error(self, reason: str) -> LaunchError:
        """Return an error of this place."""
        return LaunchError(str(self.source), self.line, reason)


def substitute(text: str, context: LaunchContext) -> str:
    r"""Return a text with its substitutions made; behind a backslash, every character is itself, as in ROS.

    Raises:
        LaunchError: an unknown or refused substitution, or one that fails; with its place.
    """
    if text.count("$(") > MOST:
        raise context.error(f"more than {MOST} substitutions in one text")
    made, at = [], 0
    while at < len(text):
        piece, at = _piece(text, at, context)
        made.append(piece)
    return "".join(made)


def truth(text: str, context: LaunchContext, what: str = "a condition") -> bool:
    """Return the truth value that a text, after substitution, spells; an error says `what` it is of.

    Raises:
        LaunchError: it is neither true nor false.
    """
    word = substitute(text, context).strip().lower()
    if word in TRUE or word in FALSE:
        return word in TRUE
    how = "a variable is $(var NAME), and texts are compared by $(equals $(var NAME) VALUE)"
    raise context.error(f"{what} is true, false, 1 or 0, not {word!r}; {how}")


def _piece(text: str, at: int, context: LaunchContext) -> tuple[str, int]:
    """Read one substitution, or one character that is itself; return it and where it goes on."""
    if text.startswith("$(", at):
        return _inside(text, at + 2, context)
    if text[at] == "\\" and at + 1 < len(text):
        at += 1
    return text[at], at + 1


def _inside(text: str, at: int, context: LaunchContext) -> tuple[str, int]:
    """Read from behind `$(` to its closing bracket; parts of words may be quoted, or substitutions themselves."""
    began, words = at, []
    word: str | None = None
    while at < len(text):
        if text[at].isspace() or text[at] == ")":
            words += [] if word is None else [word]
            word, at = None, at + 1
            if text[at - 1] == ")":
                return _apply(words, context), at
        elif text[at] in "'\"":
            quoted = _QUOTED.match(text, at)
            if quoted is None:
                raise context.error(f"a quotation mark is missing in {text!r}")
            word, at = (word or "") + substitute(quoted[2], context), quoted.end()
        else:
            piece, at = _piece(text, at, context)
            word = (word or "") + piece
    raise context.error(f"$({text[began:]}: the closing bracket is missing")


def _apply(asked: list[str], context: LaunchContext) -> str:
    name, words = (asked[0], asked[1:]) if asked else ("", [])
    if name not in _KNOWN:
        hint = nearest(name, _KNOWN) or f"; the value of an argument is $(var {name})"
        raise context.error(f"unknown substitution $({name} ...){hint} (available: {listing(sorted(_KNOWN))})")
    fewest, most, function = _KNOWN[name]
    if not fewest <= len(words) <= most:
        amount = str(fewest) if fewest == most else f"{fewest} or {most}"
        raise context.error(f"$({name} ...) takes {amount} word{'' if most == 1 else 's'}, not {len(words)}")
    try:
        return function(words, context)
    except PackageError as error:
        raise context.error(f"$({name} {' '.join(words)}): {error}") from None


def _looked_up(
    kind: str, known: Callable[[LaunchContext], Mapping[str, str]]
) -> Callable[[list[str], LaunchContext], str]:
    def look(words: list[str], context: LaunchContext) -> str:
        values = known(context)
        if words[0] not in values and len(words) == 1:
            there = f" (available: {listing(sorted(values))})" if kind == "var" else ""
            reason = f"there is none{nearest(words[0], values)}; a default: $({kind} {words[0]} VALUE)"
            raise context.error(f"$({kind} {words[0]}): {reason}{there}")
        return values.get(words[0], words[-1])

    return look


def _evaluated(words: list[str], context: LaunchContext) -> str:
    """Compute an expression of literals by the language of guards: what a condition needs, and nothing that acts."""
    try:
        expression = parse_expression(words[0])
        if expression.names:
            raise ExpressionError(words[0], f"{expression.names[0]!r} is no value; a text stands in quotation marks")
        return str(value_of(expression, {})())
    except (ExpressionError, EvaluationError) as error:
        how = "only literals are computed here, such as $(eval \"'$(var NAME)' == 'sim'\")"
        raise context.error(f"$(eval {words[0]!r}): {error}; {how}") from None


def _xacro(words: list[str], context: LaunchContext) -> str:
    """Return a robot's description, as `xacro FILE NAME:=VALUE ...` prints it; no other command is known."""
    from grip_bt.commanders.description.packages import Packages
    from grip_bt.commanders.description.xml import expand

    asked = [word for word in shlex.split(words[0]) if not word.startswith("-")]
    files = [word for word in asked if ":=" not in word]
    if len(files) != 2 or files[0] != "xacro":
        raise context.error("$(command ...) isn't run here, only `xacro FILE NAME:=VALUE ...` is understood")
    file = Path(files[1])
    try:
        return expand(file, dict(word.split(":=", 1) for word in asked if ":=" in word), Packages({}, (file,)))[0]
    except DocumentError as error:
        raise context.error(f"$(command 'xacro ...'): {error}") from None


def _logic(holds: Callable[..., bool]) -> Callable[[list[str], LaunchContext], str]:
    return lambda words, context: str(holds(*(truth(word, context) for word in words))).lower()


_KNOWN: dict[str, tuple[int, int, Callable[[list[str], LaunchContext], str]]] = {
    "var": (1, 2, _looked_up("var", lambda context: context.variables)),
    "env": (1, 2, _looked_up("env", lambda context: context.env)),
    "eval": (1, 1, _evaluated),
    "command": (1, 2, _xacro),
    "dirname": (0, 0, lambda words, context: str(context.source.resolve().parent)),
    "filename": (0, 0, lambda words, context: context.source.name),
    "find-pkg-share": (1, 1, lambda words, context: str(share_of(words[0]))),
    "find-pkg-prefix": (1, 1, lambda words, context: str(share_of(words[0]).parent.parent)),
    "exec-in-pkg": (2, 2, lambda words, context: str(executable_of(words[1], words[0]))),
    "not": (1, 1, _logic(lambda one: not one)),
    "and": (2, 2, _logic(lambda one, other: one and other)),
    "or": (2, 2, _logic(lambda one, other: one or other)),
    "equals": (2, 2, lambda words, context: str(words[0] == words[1]).lower()),
    "not-equals": (2, 2, lambda words, context: str(words[0] != words[1]).lower()),
}
