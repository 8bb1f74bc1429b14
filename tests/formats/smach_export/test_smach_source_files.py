"""What exported files of SMACH look like, and that SMACH's own words are used where SMACH can say it."""

import os
from pathlib import Path

import pytest

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.cli.__main__ import main
from grip_bt.formats.smach_export import export
from grip_bt.task import load, loads
from grip_bt.task.catalog import Catalog

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[2] / "examples"
LEGACY = HERE.parent / "smach" / "data"


def held_to(name: str, text: str) -> None:
    """Compare with the kept file; GRIP_GOLDEN=1 keeps what there is now, to be looked at."""
    file = HERE / "golden" / f"{name}.txt"
    if os.environ.get("GRIP_GOLDEN"):
        file.write_text(text)
    assert text == file.read_text()


def test_the_reactive_pick_is_written_as_it_was_looked_at():
    task = EXAMPLES / "tasks" / "reactive_pick.yaml"
    held_to("reactive_pick", export(load(task), project_catalog(task), EXAMPLES))


@pytest.mark.parametrize("stem", ["nested_with", "concurrence_exits", "iterate_list", "py2_counter"])
def test_imported_machines_are_written_as_they_were_looked_at(stem, tmp_path):
    # beside the legacy file, so that paths in the text don't hang on where the test runs
    file = tmp_path / f"{stem}.py"
    file.write_text((LEGACY / f"{stem}.py").read_text())
    assert main(["import", str(file), "--from", "smach", "--execute", "-o", str(tmp_path)]) == 0
    (path,) = tmp_path.glob("*.yaml")
    held_to(stem, export(load(path), project_catalog(path), tmp_path))


WORDS = """
grip: 1
name: words
outcomes: {success: success, failure: failure, tired: failure}
data: {names: {type: "list[str]", value: [a, b]}, n: {type: int, value: 0}}
root:
  kind: sequence
  outcomes: {tired: failure}
  exits: {tries.failure: tired}
  children:
    each:
      kind: for_each
      items: names
      item: name
      child: {say: {node: flow/log, with: {message: name}, in: {value: name}}}
    both:
      kind: parallel
      cancel: join
      children: {one: {node: flow/succeed}, two: {node: flow/log, with: {message: two}}}
    tries: {kind: retry, times: 3, child: {fails: {node: flow/fail}}}
    limited: {kind: timeout, seconds: 2, child: {waits: {node: flow/wait, with: {seconds: 1}}}}
"""


def test_containers_of_smach_are_used_where_there_are_some_and_the_rest_is_named():
    text = export(loads(WORDS), Catalog.builtin())
    for piece in (
        "Count(3)",
        'transitions={"again": "fails", "enough": "failure"}',
        "has no equivalent for: each (for_each), both (parallel), limited (timeout).",
        'task.userdata.names = ["a", "b"]',
    ):
        assert piece in " ".join(text.split()), piece
    module = {"__name__": "words", "__file__": __file__}
    exec(compile(text, "words.py", "exec"), module)


def test_text_of_a_task_stays_text_in_the_file():
    evil = '"""\nimport os\nos.abort()\n\\'
    task = loads("grip: 1\nname: a\nroot: {node: flow/succeed}\n").model_copy(update={"doc": evil})
    text = export(task, Catalog.builtin())
    compile(text, "a.py", "exec")
    assert text.count("os.abort") == 1
    assert text.index("os.abort") < text.index("def build")
    exec(compile(text, "a.py", "exec"), {"__name__": "a", "__file__": __file__})


def test_grip_convert_writes_the_file(tmp_path, capsys):
    (tmp_path / "words.yaml").write_text(WORDS)
    out = tmp_path / "words.py"
    assert main(["convert", str(tmp_path / "words.yaml"), "--to", "smach-py", "-o", str(out)]) == 0
    assert out.read_text() == export(loads(WORDS), Catalog.builtin())
    (tmp_path / "wrong.yaml").write_text(WORDS.replace("flow/fail", "flow/nothing"))
    assert main(["convert", str(tmp_path / "wrong.yaml"), "--to", "smach-py"]) == 1
    assert "tries/fails: there is no node 'flow/nothing'" in capsys.readouterr().err
