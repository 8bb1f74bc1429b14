"""The command's argument parser: argparse, which also says what was probably meant."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable, Mapping
from typing import NoReturn, TypeVar

from grip_bt.base.errors import nearest

_T = TypeVar("_T")
Reader = Callable[[str], _T]
_STRANGE = "unrecognized arguments: "
_CHOICE = re.compile(r"invalid choice: '([^']*)' \(choose from (.*)\)$")

STAND_INS = "stand in for packages, arguments, services and actions that are missing, and name them"


def add_no_code(parser: argparse.ArgumentParser) -> None:
    """Add the option of verbs that run what lies in a project."""
    refusing = "fail, listing it, where third-party code would be imported or started"
    parser.add_argument("--no-code", action="store_true", help=refusing)


def add_actions(
    parser: argparse.ArgumentParser, actions: Mapping[str, tuple[Callable[[argparse.Namespace], int | None], str]]
) -> list[argparse.ArgumentParser]:
    """Add what may follow a verb, name -> what runs it and its help; return the parser of each."""
    choices, made = parser.add_subparsers(title="actions", metavar="ACTION", required=True), []
    for name, (run, doc) in actions.items():
        made.append(choices.add_parser(name, help=doc))
        made[-1].set_defaults(run=run, usage_error=made[-1].error)
    return made


def number(above: float | None = None, least: float = 0, what: str = "a number", advice: str = "") -> Reader[float]:
    """Return what reads the number of an option: finite, and above `above`, or else `least` or more."""
    allowed = f"{what}, {least:g} or more" if above is None else f"{what} above {above:g}"

    def read(word: str) -> float:
        try:
            value = float(word)
        except ValueError:
            value = math.nan  # neither equal to, nor above, nor below anything
        if not (least <= value if above is None else above < value) or value == math.inf:
            raise argparse.ArgumentTypeError(f"{word!r} isn't {allowed}{advice}")
        return value

    return read


def whole(least: int, most: int | None = None, what: str = "a whole number") -> Reader[int]:
    """Return what reads the whole number of an option, from `least` to `most`."""
    allowed = f"{what}, {least} or more" if most is None else f"{what} from {least} to {most}"

    def read(word: str) -> int:
        digits = word.isascii() and word.isdigit() and (most is None or len(word) <= len(str(most)))
        if not digits or int(word) < least or (most is not None and int(word) > most):
            raise argparse.ArgumentTypeError(f"{word!r} isn't {allowed}")
        return int(word)

    return read


class Parser(argparse.ArgumentParser):
    """argparse's parser; a word that isn't one of the choices or options is answered with the nearest one."""

    def error(self, message: str) -> NoReturn:
        """End the program with exit status 2; in the words of argparse, and the nearest choice."""
        if found := _CHOICE.search(message):
            word, choices = found.groups()
            message += nearest(word, [choice.strip("' ") for choice in choices.split(",")])
        elif message.startswith(_STRANGE):
            message += nearest(message.removeprefix(_STRANGE).split("=")[0].split()[0], self._option_string_actions)
        super().error(message)
