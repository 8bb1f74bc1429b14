"""`$(...)` of launch files: variables, the environment, packages, folders, and simple logic. Nothing is executed."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grip_bt.base.errors import DocumentError, EvaluationError, ExpressionError, listing, nearest
from grip_bt.base.evaluation import value_of
from grip_bt.base.expression import parse_expression

from ..interfaces.ament import PackageError, executable_of, prefix_of, share_of
from .element import LaunchError

TRUE, FALSE = ("true", "1"), ("false", "0")
MOST = 100
"""Substitutions in one text, also within each other."""
_REFUSED = {
    "command": "it runs a program while the file is read (`xacro FILE NAME:=VALUE ...` is understood, and expanded "
    "by GRIP); give its output as an argument",
    "param": "it asks for a parameter that is set while nodes start",
    "find": "it is of ROS 1; write $(find-pkg-share PACKAGE)",
    "optenv": "it is of ROS 1; write $(env NAME DEFAULT)",
    "arg": "it is of ROS 1; write $(var NAME)",
}


@dataclass(frozen=True)
class Place:
    """Where a text stands, and what its substitutions see.

    Attributes:
        source: the launch file.
        line: of the element.
        variables: what `arg` and `let` have set.
        env: the environment.
        prefixes: where packages are; None for the usual places.
    """

    source: Path
    line: int
    variables: Mapping[str, str]
    env: Mapping[str, str]
    prefixes: Sequence[Path] | None = None

    def error(self, reason: str) -> LaunchError:
        """Return an error of this place."""
        return LaunchError(str(self.source), self.line, reason)


def substitute(text: str, place: Place) -> str:
    r"""Return a text with its substitutions made; behind a backslash, every character is itself, as in ROS.

    Raises:
        LaunchError: an unknown or refused substitution, or one that fails; with its place.
    """
    if text.count("$(") > MOST:
        raise place.error(f"more than {MOST} substitutions in one text")
    made, at = [], 0
    while at < len(text):
        if text[at] == "\\" and at + 1 < len(text):
            made.append(text[at + 1])
            at += 2
        else:
            piece, at = _piece(text, at, place)
            made.append(piece)
    return "".join(made)


def truth(text: str, place: Place, what: str = "a condition") -> bool:
    """Return the truth value that a text, after substitution, spells.

    Args:
        text: as it is written.
        place: where.
        what: of what it is the value, for the error.

    Raises:
        LaunchError: it is neither true nor false.
    """
    word = substitute(text, place).strip().lower()
    if word in TRUE or word in FALSE:
        return word in TRUE
    raise place.error(f"{what} is true, false, 1 or 0, not {word!r}{_compared(word)}")


def _compared(word: str) -> str:
    """Return how to write what looks like a comparison, or a variable of another language."""
    if "==" in word:
        return "; texts are compared by $(equals $(var NAME) VALUE)"
    return "; a variable is $(var NAME)" if "$" in word or "{" in word else ""


def _piece(text: str, at: int, place: Place) -> tuple[str, int]:
    """Read one substitution, or one character that is itself; return it and where it goes on."""
    return _inside(text, at + 2, place) if text.startswith("$(", at) else (text[at], at + 1)


def _inside(text: str, at: int, place: Place) -> tuple[str, int]:
    """Read from behind `$(` to its closing bracket; return the value and where it goes on."""
    words: list[str] = []
    began = at
    while True:
        while at < len(text) and text[at].isspace():
            at += 1
        if at >= len(text):
            raise place.error(f"$({text[began:]!s}: the closing bracket is missing")
        if text[at] == ")":
            break
        word, at = _word(text, at, place)
        words.append(word)
    if not words:
        raise place.error("$() is empty")
    return _apply(words[0], words[1:], place), at + 1


def _word(text: str, at: int, place: Place) -> tuple[str, int]:
    """Read one word, of which parts may be quoted or substitutions themselves."""
    made = []
    while at < len(text) and not text[at].isspace() and text[at] != ")":
        if text[at] in "'\"":
            end = _closing_quote(text, at, place)
            made.append(substitute(text[at + 1 : end], place))
            at = end + 1
        else:
            piece, at = _piece(text, at, place)
            made.append(piece)
    return "".join(made), at


def _closing_quote(text: str, at: int, place: Place) -> int:
    """Return where the text that is quoted from `at` ends; a quotation mark behind a backslash doesn't end it."""
    end = at + 1
    while end < len(text) and text[end] != text[at]:
        end += 2 if text[end] == "\\" else 1
    if end >= len(text):
        raise place.error(f"a quotation mark is missing in {text!r}")
    return end


def _apply(name: str, words: list[str], place: Place) -> str:
    if name == "command" and (asked := shlex.split(words[0] if words else ""))[:1] == ["xacro"]:
        return _xacro(asked[1:], place)
    if name in _REFUSED:
        raise place.error(f"$({name} ...) isn't run here: {_REFUSED[name]}")
    if name not in _KNOWN:
        hint = "" if name in place.variables else nearest(name, _KNOWN)
        hint = hint or f"; the value of an argument is $(var {name})"
        raise place.error(f"unknown substitution $({name} ...){hint} (there are: {listing(sorted(_KNOWN))})")
    fewest, most, function = _KNOWN[name]
    if not fewest <= len(words) <= most:
        amount = str(fewest) if fewest == most else f"{fewest} or {most}"
        raise place.error(f"$({name} ...) takes {amount} word{'' if most == 1 else 's'}, not {len(words)}")
    try:
        return function(words, place)
    except PackageError as error:
        raise place.error(f"$({name} {' '.join(words)}): {error}") from None


def _variable(words: list[str], place: Place) -> str:
    if words[0] in place.variables:
        return place.variables[words[0]]
    if len(words) > 1:
        return words[1]
    known = listing(sorted(place.variables))
    hint = nearest(words[0], place.variables) or "; one is declared by <arg> or <let>, before it is used"
    raise place.error(f"$(var {words[0]}): no such argument{hint} (there are: {known})")


def _environment(words: list[str], place: Place) -> str:
    if words[0] in place.env:
        return place.env[words[0]]
    if len(words) > 1:
        return words[1]
    raise place.error(f"$(env {words[0]}): the environment has no such variable; a default: $(env {words[0]} VALUE)")


def _evaluated(words: list[str], place: Place) -> str:
    """Compute an expression of literals by the language of guards: what a condition needs, and nothing that acts."""
    try:
        expression = parse_expression(words[0])
        if expression.names:
            raise place.error(
                f"$(eval {words[0]!r}): {expression.names[0]!r} is no value; a text stands in quotation marks: "
                "$(eval \"'$(var NAME)' == 'sim'\")"
            )
        return str(value_of(expression, {})())
    except (ExpressionError, EvaluationError) as error:
        raise place.error(
            f"$(eval {words[0]!r}): {error}; Python code isn't run here: write it with if/unless, `equals`, `not`"
        ) from None


def _xacro(words: list[str], place: Place) -> str:
    """Return a robot's description, as `xacro FILE NAME:=VALUE ...` prints it."""
    from grip_bt.commanders.description.packages import Packages
    from grip_bt.commanders.description.xacro_files import expand

    files = [word for word in words if ":=" not in word and not word.startswith("-")]
    if len(files) != 1:
        raise place.error(f"$(command 'xacro ...'): it is given one file, not {len(files)}")
    shares = [folder for prefix in reversed(place.prefixes or ()) for folder in sorted((prefix / "share").glob("*"))]
    packages = Packages({folder.name: folder for folder in shares if folder.is_dir()}, (Path(files[0]),))
    try:
        return expand(Path(files[0]), dict(word.split(":=", 1) for word in words if ":=" in word), packages)
    except DocumentError as error:
        raise place.error(f"$(command 'xacro ...'): {error}") from None


def _logic(words: list[str], place: Place) -> list[bool]:
    return [truth(word, place) for word in words]


def _said(value: bool) -> str:
    return "true" if value else "false"


_KNOWN: dict[str, tuple[int, int, Callable[[list[str], Place], str]]] = {
    "var": (1, 2, _variable),
    "env": (1, 2, _environment),
    "eval": (1, 1, _evaluated),
    "dirname": (0, 0, lambda words, place: str(place.source.resolve().parent)),
    "filename": (0, 0, lambda words, place: place.source.name),
    "find-pkg-share": (1, 1, lambda words, place: str(share_of(words[0], place.prefixes))),
    "find-pkg-prefix": (1, 1, lambda words, place: str(prefix_of(words[0], place.prefixes))),
    "exec-in-pkg": (2, 2, lambda words, place: str(executable_of(words[1], words[0], place.prefixes))),
    "not": (1, 1, lambda words, place: _said(not _logic(words, place)[0])),
    "and": (2, 2, lambda words, place: _said(all(_logic(words, place)))),
    "or": (2, 2, lambda words, place: _said(any(_logic(words, place)))),
    "equals": (2, 2, lambda words, place: _said(words[0] == words[1])),
    "not-equals": (2, 2, lambda words, place: _said(words[0] != words[1])),
}
