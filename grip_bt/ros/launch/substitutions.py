"""`$(...)` of launch files: variables, the environment, packages, folders, and simple logic. Nothing is executed."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from grip_bt.base.errors import DocumentError, EvaluationError, ExpressionError, listing, nearest
from grip_bt.base.evaluation import value_of
from grip_bt.base.expression import parse_expression
from grip_bt.ros.interfaces.packages import PackageError, executable_of, prefix_of, share_of

from .element import LaunchError

TRUE, FALSE = ("true", "1"), ("false", "0")
MOST = 100
"""Substitutions in one text, also within each other."""
_REFUSED = {
    "command": "it runs a program while the file is read (`xacro FILE NAME:=VALUE ...` is understood, and expanded "
    "by GRIP); give its output as an argument",
    "param": "it asks for a parameter that is set while nodes start",
    "find": "it is ROS 1 syntax; write $(find-pkg-share PACKAGE)",
    "optenv": "it is ROS 1 syntax; write $(env NAME DEFAULT)",
    "arg": "it is ROS 1 syntax; write $(var NAME)",
}


@dataclass
class LaunchContext:
    """Where a text stands, and what its substitutions see.

    Attributes:
        source: the launch file.
        line: of the element.
        variables: what `arg` and `let` have set.
        env: the environment.
    """

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
        if text[at] == "\\" and at + 1 < len(text):
            made.append(text[at + 1])
            at += 2
        else:
            piece, at = _piece(text, at, context)
            made.append(piece)
    return "".join(made)


def truth(text: str, context: LaunchContext, what: str = "a condition") -> bool:
    """Return the truth value that a text, after substitution, spells.

    Args:
        text: as it is written.
        context: where.
        what: of what it is the value, for the error.

    Raises:
        LaunchError: it is neither true nor false.
    """
    word = substitute(text, context).strip().lower()
    if word in TRUE or word in FALSE:
        return word in TRUE
    raise context.error(f"{what} is true, false, 1 or 0, not {word!r}{_compared(word)}")


def _compared(word: str) -> str:
    """Return how to write what looks like a comparison, or a variable of another language."""
    if "==" in word:
        return "; texts are compared by $(equals $(var NAME) VALUE)"
    return "; a variable is $(var NAME)" if "$" in word or "{" in word else ""


def _piece(text: str, at: int, context: LaunchContext) -> tuple[str, int]:
    """Read one substitution, or one character that is itself; return it and where it goes on."""
    return _inside(text, at + 2, context) if text.startswith("$(", at) else (text[at], at + 1)


def _inside(text: str, at: int, context: LaunchContext) -> tuple[str, int]:
    """Read from behind `$(` to its closing bracket; return the value and where it goes on."""
    words: list[str] = []
    began = at
    while True:
        while at < len(text) and text[at].isspace():
            at += 1
        if at >= len(text):
            raise context.error(f"$({text[began:]!s}: the closing bracket is missing")
        if text[at] == ")":
            break
        word, at = _word(text, at, context)
        words.append(word)
    if not words:
        raise context.error("$() is empty")
    return _apply(words[0], words[1:], context), at + 1


def _word(text: str, at: int, context: LaunchContext) -> tuple[str, int]:
    """Read one word, of which parts may be quoted or substitutions themselves."""
    made = []
    while at < len(text) and not text[at].isspace() and text[at] != ")":
        if text[at] in "'\"":
            end = _closing_quote(text, at, context)
            made.append(substitute(text[at + 1 : end], context))
            at = end + 1
        else:
            piece, at = _piece(text, at, context)
            made.append(piece)
    return "".join(made), at


def _closing_quote(text: str, at: int, context: LaunchContext) -> int:
    """Return where the text that is quoted from `at` ends; a quotation mark behind a backslash doesn't end it."""
    end = at + 1
    while end < len(text) and text[end] != text[at]:
        end += 2 if text[end] == "\\" else 1
    if end >= len(text):
        raise context.error(f"a quotation mark is missing in {text!r}")
    return end


def _apply(name: str, words: list[str], context: LaunchContext) -> str:
    if name == "command" and (asked := shlex.split(words[0] if words else ""))[:1] == ["xacro"]:
        return _xacro(asked[1:], context)
    if name in _REFUSED:
        raise context.error(f"$({name} ...) isn't run here: {_REFUSED[name]}")
    if name not in _KNOWN:
        hint = "" if name in context.variables else nearest(name, _KNOWN)
        hint = hint or f"; the value of an argument is $(var {name})"
        raise context.error(f"unknown substitution $({name} ...){hint} (available: {listing(sorted(_KNOWN))})")
    fewest, most, function = _KNOWN[name]
    if not fewest <= len(words) <= most:
        amount = str(fewest) if fewest == most else f"{fewest} or {most}"
        raise context.error(f"$({name} ...) takes {amount} word{'' if most == 1 else 's'}, not {len(words)}")
    try:
        return function(words, context)
    except PackageError as error:
        raise context.error(f"$({name} {' '.join(words)}): {error}") from None


def _variable(words: list[str], context: LaunchContext) -> str:
    if words[0] in context.variables:
        return context.variables[words[0]]
    if len(words) > 1:
        return words[1]
    known = listing(sorted(context.variables))
    hint = nearest(words[0], context.variables) or "; one is declared by <arg> or <let>, before it is used"
    raise context.error(f"$(var {words[0]}): no such argument{hint} (available: {known})")


def _environment(words: list[str], context: LaunchContext) -> str:
    if words[0] in context.env:
        return context.env[words[0]]
    if len(words) > 1:
        return words[1]
    raise context.error(f"$(env {words[0]}): the environment has no such variable; a default: $(env {words[0]} VALUE)")


def _evaluated(words: list[str], context: LaunchContext) -> str:
    """Compute an expression of literals by the language of guards: what a condition needs, and nothing that acts."""
    try:
        expression = parse_expression(words[0])
        if expression.names:
            raise context.error(
                f"$(eval {words[0]!r}): {expression.names[0]!r} is no value; a text stands in quotation marks: "
                "$(eval \"'$(var NAME)' == 'sim'\")"
            )
        return str(value_of(expression, {})())
    except (ExpressionError, EvaluationError) as error:
        raise context.error(
            f"$(eval {words[0]!r}): {error}; Python code isn't run here: write it with if/unless, `equals`, `not`"
        ) from None


def _xacro(words: list[str], context: LaunchContext) -> str:
    """Return a robot's description, as `xacro FILE NAME:=VALUE ...` prints it."""
    from grip_bt.commanders.description.packages import Packages
    from grip_bt.commanders.description.xml import expand

    files = [word for word in words if ":=" not in word and not word.startswith("-")]
    if len(files) != 1:
        raise context.error(f"$(command 'xacro ...'): it is given one file, not {len(files)}")
    packages = Packages({}, (Path(files[0]),))
    try:
        return expand(Path(files[0]), dict(word.split(":=", 1) for word in words if ":=" in word), packages)[0]
    except DocumentError as error:
        raise context.error(f"$(command 'xacro ...'): {error}") from None


def _logic(words: list[str], context: LaunchContext) -> list[bool]:
    return [truth(word, context) for word in words]


def _said(value: bool) -> str:
    return "true" if value else "false"


_KNOWN: dict[str, tuple[int, int, Callable[[list[str], LaunchContext], str]]] = {
    "var": (1, 2, _variable),
    "env": (1, 2, _environment),
    "eval": (1, 1, _evaluated),
    "dirname": (0, 0, lambda words, context: str(context.source.resolve().parent)),
    "filename": (0, 0, lambda words, context: context.source.name),
    "find-pkg-share": (1, 1, lambda words, context: str(share_of(words[0]))),
    "find-pkg-prefix": (1, 1, lambda words, context: str(prefix_of(words[0]))),
    "exec-in-pkg": (2, 2, lambda words, context: str(executable_of(words[1], words[0]))),
    "not": (1, 1, lambda words, context: _said(not _logic(words, context)[0])),
    "and": (2, 2, lambda words, context: _said(all(_logic(words, context)))),
    "or": (2, 2, lambda words, context: _said(any(_logic(words, context)))),
    "equals": (2, 2, lambda words, context: _said(words[0] == words[1])),
    "not-equals": (2, 2, lambda words, context: _said(words[0] != words[1])),
}
