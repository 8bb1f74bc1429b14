"""docs/python.md: what it shows runs, in order, and the names that it lists are those that there are."""

import contextlib
import io
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

import grip_bt

PAGE = (Path(__file__).parents[2] / "docs" / "python.md").read_text(encoding="utf-8")
FENCES = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
BUILT = """\
grip: 1
name: count
data: {is_far: {type: bool, value: false}, n: {type: int, value: 0}}
root:
  kind: loop
  while: not is_far
  child:
    sequence:
      kind: sequence
      children:
        count: {node: flow/count, in: {count: n}, out: {count: n}}
        far: {node: count/far, with: {limit: 3}, in: {n: n}, out: {far: is_far}}

"""
SAID = [
    "nothing is wrong\nsuccess success 3 3\n",
    "/ failure no_luck\nno_luck\n",
    BUILT + "4\n",
    "no_luck\n13 success\n",
    "3\n",
    "success {'n': 1}\n",
]


def test_its_fences_run_in_order_and_say_what_the_page_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert len(FENCES) == len(SAID)
    for fence, said in zip(FENCES, SAID, strict=True):
        monkeypatch.setitem(sys.modules, "docs_page", page := ModuleType("docs_page"))
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(compile(fence, "docs/python.md", "exec"), vars(page))
        assert out.getvalue() == said
    assert (tmp_path / "count.svg").read_text().startswith("<svg")


def test_the_names_at_the_top_are_listed_and_few():
    table = PAGE[PAGE.index("## The names") :]
    listed = set(re.findall(r"`(\w+)`", table))
    assert listed == set(grip_bt.__all__)
    assert len(grip_bt.__all__) <= 40


def test_a_notebook_shows_a_task_and_tasks_are_equal_wherever_they_were_read(tmp_path):
    text = "{grip: 1, name: one, root: {node: flow/succeed}}"
    (tmp_path / "one.yaml").write_text(text)
    task = grip_bt.load(tmp_path / "one.yaml")
    assert task == grip_bt.loads(text)
    assert (task.file, grip_bt.loads(text).file) == (str(tmp_path / "one.yaml"), "")
    assert task._repr_svg_() == task.show()._repr_svg_() == grip_bt.draw(task).svg
    assert grip_bt.run(task, robot="fake").status == "success"
    assert (tmp_path / ".grip" / "runs.sqlite").is_file()


TWO = """
grip: 1
name: two
data: {n: {type: int, value: 3}}
root:
  kind: fallback
  children:
    less: {node: flow/fail, with: {code: "<none>"}}
    step: {node: flow/count, in: {count: n}, out: {count: n}}
"""


def test_a_machine_is_executed_by_hand_as_a_tree_is_ticked():
    task = grip_bt.loads(TWO)
    with task.machine(data={"n": 7}) as machine:
        assert (machine.outcome, machine.execute(), machine.outcome) == (None, "success", "success")
        assert (machine.failure, machine.data) == (None, {"n": 8})
    with task.tree(data={"n": 7}) as tree:
        before = tree._repr_svg_()
        tree.root.tick_once()
        assert (tree.outcome, tree.data) == ("success", {"n": 8})
        assert tree._repr_svg_() == tree._drawn({"/": "success", "less": "failure", "step": "success"}) != before
    assert before == task._repr_svg_()
    failed = grip_bt.loads("{grip: 1, name: one, root: {node: flow/fail, with: {code: no_luck}}}")
    with failed.machine() as machine:
        assert (machine.execute(), machine.failure.code) == ("failure", "no_luck")


def test_a_result_can_be_asked_and_shows_itself_as_tables(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = grip_bt.run(grip_bt.loads(TWO), robot="fake")
    ends = [(each.path, each.outcome, each.code) for each in result.events() if each.event == "exit"]
    assert ends == [("less", "failure", "<none>"), ("step", "success", None), ("/", "success", None)]
    shown = result._repr_html_()
    assert "<td>n</td><td>4</td>" in shown
    assert "<td>less</td><td>failure</td><td>&lt;none&gt;</td>" in shown


def test_a_world_is_had_by_its_name_and_what_is_unknown_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert grip_bt.World("table") == grip_bt.World.like("table")
    assert grip_bt.World("table", fallen_below=-0.1).fallen_below == -0.1
    with pytest.raises(grip_bt.GripError, match="unknown world 'tabel'; did you mean 'table'"):
        grip_bt.World("tabel")
    task = grip_bt.loads(TWO)
    for use in (grip_bt.run, grip_bt.tree):
        with pytest.raises(grip_bt.GripError, match="unknown kind of robot 'simm'; did you mean 'sim'"):
            use(task, robot="simm")
