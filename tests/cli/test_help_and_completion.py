"""Help shows the verbs that a newcomer needs, then all; shells complete verbs, options and the verbs below."""

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path
from runpy import run_path

import pytest

from grip_bt.cli import terminal
from grip_bt.cli.__main__ import main
from grip_bt.cli.shell import FIRST, GROUPS, VERBS, actions_of, make_parser


def shown(capsys, *words):
    status: object = 0
    try:
        status = main(list(words))
    except SystemExit as done:
        status = done.code
    assert status == 0
    return capsys.readouterr().out


def test_help_lists_what_matters_and_all_of_it_when_asked(capsys):
    first, everything = shown(capsys, "--help"), shown(capsys, "help", "all")
    assert all(f"\n  {verb}" in first for verb in FIRST)
    assert not [verb for verb in VERBS if verb not in FIRST and f"\n  {verb}" in first]
    assert "grip help all" in first
    assert all(f"\n  {verb}" in everything for verb in VERBS)
    assert all(f"\n{title}:\n" in everything for title in GROUPS)
    assert len(FIRST) == 8
    assert shown(capsys, "help") == shown(capsys) == first


@pytest.mark.parametrize("verb", VERBS)
def test_help_of_a_verb_is_what_the_verb_says_of_itself(verb, capsys):
    assert shown(capsys, "help", verb) == shown(capsys, verb, "--help")


ROOT = Path(__file__).parents[2]


def test_what_is_printed_for_shells_is_of_these_verbs():
    for name, made in run_path(str(ROOT / "tools" / "completion.py"))["scripts"]().items():
        assert (ROOT / "grip_bt" / "cli" / name).read_text() == made, "run: python tools/completion.py"


def test_printing_it_loads_no_verb():
    loaded = "sorted(each for each in sys.modules if each.startswith(('grip_bt.app', 'numpy', 'rclpy', 'pydantic')))"
    code = "import sys; from grip_bt.cli.__main__ import main; main(['completion', 'bash'])"
    code += f"\nprint({loaded}, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"


COMPLETE = 'source "$1"; COMP_WORDS=($2 "$3"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _grip; echo "${COMPREPLY[@]}"'


@pytest.mark.parametrize(
    ("before", "word", "found"),
    [
        ("grip", "ru", {"run", "runs"}),
        ("grip", "wor", {"world"}),
        ("grip run", "--see", {"--seed"}),
        ("grip world", "sh", {"show"}),
        ("grip run --as", "", {"bt", "sm"}),
        ("grip component add", "--out", {"--outcomes"}),
        ("grip demo", "un", {"unscrew"}),
        ("grip check", "tasks/", set()),  # files are the shell's own
    ],
)
def test_bash_completes_verbs_options_and_verbs_below(before, word, found, capsys, tmp_path):
    script = tmp_path / "grip.bash"
    script.write_text(shown(capsys, "completion", "bash"))
    said = subprocess.run(
        ["bash", "-c", COMPLETE, "-", script, before, word], capture_output=True, text=True, check=True
    )
    assert set(said.stdout.split()) == found


def test_fish_completes_what_bash_does_and_says_what_it_means(capsys, tmp_path):
    script = tmp_path / "grip.fish"
    script.write_text(shown(capsys, "completion", "fish"))
    assert "-l seed -d 'of the simulated world (default: 0)'" in script.read_text()
    if not shutil.which("fish"):
        return
    asked = {
        "grip run --see": "--seed",
        "grip run --as s": "sm",
        "grip component add --outc": "--outcomes",
        "grip demo un": "unscrew",
    }
    said = ["fish", "--no-config", "-c", f"source {script}; for at in $argv; complete -C $at; end", *asked]
    found = subprocess.run(said, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [line.partition("\t")[0] for line in found] == list(asked.values())


def test_zsh_reads_what_is_printed_for_it(capsys, tmp_path):
    script = tmp_path / "grip.zsh"
    script.write_text(shown(capsys, "completion", "zsh"))
    assert "--seed" in script.read_text()
    if shutil.which("zsh"):
        subprocess.run(["zsh", "-n", script], check=True)


MADE_OR_SERVED = {
    *("new", "apply", "convert", "component new", "component add", "object add", "world new"),
    *("messages add", "messages push", "messages delete", "messages reset", "messages save", "messages serve"),
    *("sim", "serve", "edit", "docs", "completion", "help"),
}
"""Verbs that report nothing: they make a file, or go on until they are stopped."""


def test_every_verb_that_reports_does_so_as_json_too_and_all_are_quiet_or_loud_when_told():
    parsers = {}
    for verb in VERBS:
        (below,) = (a for a in make_parser([verb])._actions if isinstance(a, argparse._SubParsersAction))
        own = below.choices[verb]
        parsers |= {f"{verb} {name}": each for name, each in actions_of(own).items()} or {verb: own}
    said = {name: set(parser._option_string_actions) for name, parser in parsers.items()}
    assert {name for name in said if "--json" not in said[name]} == MADE_OR_SERVED
    assert all({"-q", "--quiet", "-v", "--verbose"} <= options for options in said.values())


@pytest.mark.parametrize("words", [("-q", "robot", "list"), ("robot", "-q", "list"), ("robot", "list", "-q")])
def test_where_quiet_is_said_does_not_matter(words, capsys):
    shown(capsys, *words)
    assert terminal.quiet


@pytest.mark.parametrize("verb", ["robot list", "world list", "object list", "runs", "component list"])
def test_lists_are_json_when_asked(verb, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    assert isinstance(json.loads(shown(capsys, *verb.split(), "--json")), list | dict)
