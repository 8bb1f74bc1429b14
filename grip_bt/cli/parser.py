"""The command's argument parser: argparse, which also says what was probably meant."""

from __future__ import annotations

import argparse
import re
from typing import NoReturn

from grip_bt.base.errors import nearest

_CHOICE = re.compile(r"invalid choice: '([^']*)' \(choose from (.*)\)$")


def add_no_code(parser: argparse.ArgumentParser) -> None:
    """Add the option of verbs that run what lies in a project."""
    parser.add_argument(
        "--no-code",
        action="store_true",
        help="refuse, with a list, where code that isn't GRIP's would be imported or started",
    )


class Parser(argparse.ArgumentParser):
    """argparse's parser; a word that isn't one of the choices is answered with the nearest one."""

    def error(self, message: str) -> NoReturn:
        """End the program with exit status 2; in the words of argparse, and the nearest choice."""
        if found := _CHOICE.search(message):
            word, choices = found.groups()
            message += nearest(word, [choice.strip("' ") for choice in choices.split(",")])
        super().error(message)
