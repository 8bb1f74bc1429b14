"""`grip completion`: what makes a shell complete verbs, options and files."""

from __future__ import annotations

import argparse

from .shell import VERBS, make_parser

_BASH = """_grip() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} verb=
    [ "$COMP_CWORD" -gt 1 ] && verb=${{COMP_WORDS[1]}}
    case $verb in
        "") COMPREPLY=($(compgen -W "{verbs}" -- "$word")) ;;
{cases}
    esac
}}
complete -o default -F _grip grip
"""
_ZSH = "autoload -U +X bashcompinit && bashcompinit\n" + _BASH


def add_completion(parser: argparse.ArgumentParser) -> None:
    """Add the verb's options."""
    parser.add_argument(
        "shell", choices=("bash", "zsh", "fish"), help="source what it prints: source <(grip completion bash)"
    )
    parser.set_defaults(run=_run)


def _run(args: argparse.Namespace) -> int:
    words = {verb: _words(verb) for verb in VERBS}
    if args.shell == "fish":
        print("\n".join(_fish(words)))
        return 0
    cases = "\n".join(
        f'        {verb}) COMPREPLY=($(compgen -W "{" ".join(w)}" -- "$word")) ;;' for verb, w in words.items() if w
    )
    print((_ZSH if args.shell == "zsh" else _BASH).format(verbs=" ".join(VERBS), cases=cases), end="")
    return 0


def _words(verb: str) -> list[str]:
    """Return a verb's options, and the verbs below it."""
    (subparsers,) = (a for a in make_parser([verb])._actions if isinstance(a, argparse._SubParsersAction))
    found: list[str] = []
    for action in subparsers.choices[verb]._actions:
        found += [option for option in action.option_strings if option.startswith("--")]
        found += list(action.choices) if isinstance(action, argparse._SubParsersAction) else []
    return sorted(found)


def _fish(words: dict[str, list[str]]) -> list[str]:
    lines = [
        f"complete -c grip -n __fish_use_subcommand -a {verb} -d '{doc.replace(chr(39), chr(92) + chr(39))}'"
        for verb, doc in VERBS.items()
    ]
    for verb, options in words.items():
        for option in options:
            given = f"-l {option[2:]}" if option.startswith("--") else f"-a {option}"
            lines.append(f"complete -c grip -n '__fish_seen_subcommand_from {verb}' {given}")
    return lines
