import re
from pathlib import Path
from typing import get_args

from grip_bt.task.edit import AnyCommand
from grip_gui.editing.layout import read_layout, write_layout

PAGE = (Path(__file__).parents[3] / "docs" / "editing.md").read_text()


def test_the_example_of_the_page_runs():
    exec(compile(re.findall(r"```python\n(.*?)```", PAGE, re.S)[0], "docs/editing.md", "exec"), {})


def test_the_page_lists_every_command():
    cells = [line.split("|")[1] for line in PAGE.split("\n") if line.startswith("| `")]
    rows = set(re.findall(r"`(\w+)`", " ".join(cells))) - {"do"}
    assert rows == {command.model_fields["do"].default for command in get_args(AnyCommand)}


def test_the_layout_of_the_page_is_canonical():
    text = re.findall(r"```yaml\n(.*?)```", PAGE, re.S)[0]
    assert write_layout(read_layout(text)) == text
