"""The README stays short, its commands exist, its links lead somewhere, and its excerpt is really in the example."""

import re
import shlex
from pathlib import Path

import pytest

from grip_bt.cli.shell import make_parser
from grip_bt.task import load
from grip_bt.task.model import walk

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / "README.md").read_text()
COMMANDS = [line for line in re.findall(r"^(?:\.venv/bin/)?grip .*", TEXT, re.MULTILINE)]


def test_it_has_at_most_400_words():
    assert len(TEXT.split()) <= 400


@pytest.mark.parametrize("line", COMMANDS)
def test_its_commands_are_understood(line):
    words = shlex.split(line, comments=True)
    assert make_parser(words[1:]).parse_args(words[1:]).run


def test_there_are_commands_to_check():
    assert len(COMMANDS) >= 5


@pytest.mark.parametrize("target", re.findall(r"\]\((?!https?:)([^)#]+)\)", TEXT))
def test_its_links_lead_to_files(target):
    assert (ROOT / target).is_file()


def test_its_make_targets_exist():
    makefile = (ROOT / "Makefile").read_text()
    for target in set(re.findall(r"^make (\w+)", TEXT, re.MULTILINE)):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


def test_the_nodes_of_its_excerpt_are_those_of_the_example():
    nodes = {
        node.node for _, node in walk(load(ROOT / "examples/tasks/reactive_pick.yaml").root) if hasattr(node, "node")
    }
    shown = set(re.findall(r"\{node: ([\w/]+)", TEXT))
    assert shown
    assert shown <= nodes
