"""docs/launching.md and docs/messages.md say what is so."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from grip_bt.app.project.folder import find_project
from grip_bt.base.message_store import STANDARD, MessageLibrary
from grip_bt.ros.messages.wire import MESSAGES
from grip_bt.task.catalog.ros_config import ControllerConfig
from grip_bt.task.catalog.start import ProcessConfig, Start

DOCS = Path(__file__).parents[2] / "docs"
LAUNCHING, MESSAGES_PAGE, PROJECT = (
    (DOCS / f"{name}.md").read_text() for name in ("launching", "messages", "project_file")
)


def fences(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("text", fences(LAUNCHING, "yaml"))
def test_projects_of_the_page_can_be_read(tmp_path, text):
    (tmp_path / "grip.yaml").write_text(text)
    file = find_project(tmp_path).file
    assert file.processes or file.ros


def test_every_key_of_a_process_and_of_a_controller_is_told():
    keys = set(ProcessConfig.model_fields) | set(Start.model_fields) | set(ControllerConfig.model_fields)
    assert {key for key in keys - {"doc"} if f"`{key}`" not in PROJECT} == set()


def test_files_of_the_page_can_be_read_as_messages(tmp_path):
    names = re.findall(r"^`messages/(\w+\.yaml)`$", MESSAGES_PAGE, re.MULTILINE)
    for name, text in zip(names, fences(MESSAGES_PAGE, "yaml"), strict=True):
        (tmp_path / name).write_text(text)
    library = MessageLibrary(tmp_path)
    assert [len(library.store(s)) for s in ("joint_states", "poses", "robot_poses", "trajectories")] == [1, 1, 1, 1]


def test_the_python_of_the_page_runs():
    for text in fences(MESSAGES_PAGE, "python"):
        exec(compile(text, "docs/messages.md", "exec"), {})


def test_every_store_is_told_with_its_value_and_message():
    for name, value in STANDARD.items():
        assert f"| `{name}` | `{value}` | `{MESSAGES[name]}` |" in MESSAGES_PAGE
