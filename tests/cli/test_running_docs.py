"""`docs/running.md` is held to what it says."""

from __future__ import annotations

import re
from pathlib import Path

from ruamel.yaml import YAML

from grip_bt.app.runs.mocks import read_mocks
from grip_bt.cli.shell import make_parser
from grip_bt.runtime.control import COMMANDS
from grip_bt.runtime.debugger import STEPS

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "running.md").read_text()


def test_every_option_and_only_those_are_in_the_usage(capsys) -> None:
    usage = PAGE.split("\n\n")[2]
    try:
        make_parser(["run"]).parse_args(["run", "--help"])
    except SystemExit:
        pass
    there = set(re.findall(r"(--[a-z-]+)", capsys.readouterr().out)) - {"--help"}
    assert set(re.findall(r"(--[a-z-]+)", usage)) == there


def test_every_command_of_the_protocol_is_in_its_table() -> None:
    table = (DOCS / "protocols.md").read_text().split("## The control protocol")[1].split("\n## ")[0]
    rows = [line.split("|")[1] for line in table.splitlines() if line[:3] == "| `"]
    named = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
    assert set(COMMANDS) <= named
    events = {
        "started",
        "state",
        "held",
        "committed",
        "breakpoint",
        "cleared",
        "breakpoints",
        "data",
        "refused",
        "ended",
    }
    assert named == set(COMMANDS) | events


def test_every_step_is_named() -> None:
    assert all(f"`{how}`" in PAGE for how in STEPS)


def test_the_file_of_mocks_in_it_can_be_read(tmp_path: Path) -> None:
    (text,) = (text for text in re.findall(r"```yaml\n(.*?)```", PAGE, re.S) if "mocks:" in text)
    (tmp_path / "mocks.yaml").write_text(text)
    steps = read_mocks(tmp_path / "mocks.yaml")
    assert list(steps) == list(YAML(typ="safe").load(text)["mocks"])
    assert [s["times"] for s in steps["attempt/look"]] == [2, 1]
