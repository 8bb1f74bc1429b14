"""Help shows the verbs that a newcomer needs, then all; shells complete verbs, options and the verbs below."""

import shutil
import subprocess

import pytest

from grip_bt.cli.__main__ import main
from grip_bt.cli.shell import FIRST, GROUPS, VERBS


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


COMPLETE = 'source "$1"; COMP_WORDS=($2 "$3"); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _grip; echo "${COMPREPLY[@]}"'


@pytest.mark.parametrize(
    ("before", "word", "found"),
    [
        ("grip", "ru", {"run", "runs"}),
        ("grip", "wor", {"world"}),
        ("grip run", "--see", {"--seed"}),
        ("grip world", "sh", {"show"}),
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


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_read_what_is_printed_for_them(shell, capsys, tmp_path):
    script = tmp_path / f"grip.{shell}"
    script.write_text(shown(capsys, "completion", shell))
    assert "--seed" in script.read_text() or "-l seed" in script.read_text()
    if shutil.which(shell):
        subprocess.run([shell, "-n", script], check=True)
