"""What makes shells complete verbs, options and their values, made from the command's parsers.

`python tools/completion.py` writes it, so that printing it loads no verb; a test fails when it is older than the verbs.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from grip_bt.cli.shell import VERBS, actions_of, make_parser

HERE = Path(__file__).parent
SCRIPTS = HERE.parent / "grip_bt" / "cli"
Words = dict[str, str]
"""What may be typed -> what it means."""


def scripts() -> dict[str, str]:
    """Return the files: name -> text."""
    places = {"": VERBS}
    for verb in VERBS:
        places |= _places(verb)
    cases = "\n".join(f'        "{at}") echo "{" ".join(words)}" ;;' for at, words in places.items() if words)
    fish = (line for place, words in places.items() for line in _fish(place, words))
    bash = (HERE / "completion.bash.in").read_text().replace("@CASES@", cases)
    return {"completion.bash": bash, "completion.fish": "".join(f"{line}\n" for line in fish)}


def _places(verb: str) -> dict[str, Words]:
    """Return what may follow a verb, each of its actions, and each option that takes one of several words."""
    (subparsers,) = (a for a in make_parser([verb])._actions if isinstance(a, argparse._SubParsersAction))
    own, found = subparsers.choices[verb], dict[str, Words]()
    parsers = {verb: own, **{f"{verb} {name}": parser for name, parser in actions_of(own).items()}}
    for place, parser in parsers.items():
        found[place], expand = {}, parser._get_formatter()._expand_help
        for action in parser._actions:
            options = [option for option in action.option_strings if option.startswith("--")]
            said = expand(action) if action.help else ""
            listed = {str(c): said for c in action.choices or ()}
            if isinstance(action, argparse._SubParsersAction):
                listed = {line.dest: expand(line) for line in action._choices_actions}
            found[place] |= dict.fromkeys(options, said) or listed
            found |= {f"{verb} {option}": listed for option in options if listed}
    return found


def _fish(place: str, words: Words) -> Iterator[str]:
    """Yield what makes fish complete words at a place: a verb, one of its actions, or an option's value."""
    verb, _, behind = place.partition(" ")
    if behind.startswith("--"):
        yield f"complete -c grip -n '__fish_seen_subcommand_from {verb}' -l {behind[2:]} -xa '{' '.join(words)}'"
        return
    at = " ; and ".join(f"__fish_seen_subcommand_from {word}" for word in place.split())
    for word, said in words.items():
        quoted = said.replace("\\", "\\\\").replace("'", "\\'")
        if word.startswith("--"):
            yield f"complete -c grip -n '{at}' -l {word[2:]} -d '{quoted}'"
        else:
            first = f"__fish_is_nth_token {len(place.split()) + 1}"
            yield f"complete -c grip -n '{first}{' ; and ' if at else ''}{at}' -a {word} -d '{quoted}'"


if __name__ == "__main__":
    for name, text in scripts().items():
        (SCRIPTS / name).write_text(text, encoding="utf-8")
