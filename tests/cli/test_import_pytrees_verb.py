"""`grip import --from pytrees`: XML is read, code is run only when somebody says so, in a process of its own."""

import pytest

from grip_bt.task import loads

XML = (
    '<root main_tree_to_execute="Main"><BehaviorTree ID="Main"><Sequence>'
    '<flow.succeed/><Retry num_failures="3"><flow.fail/></Retry></Sequence></BehaviorTree></root>'
)
CODE = """\
import py_trees
from py_trees.behaviours import Success
from py_trees.common import ParallelPolicy

print("a word of the module")


def build():
    one, two = Success("one"), py_trees.timers.Timer("two", duration=0.1)
    return py_trees.composites.Parallel("both", ParallelPolicy.SuccessOnSelected([two]), [one, two])


def leaves():
    raise SystemExit(3)


tree = py_trees.trees.BehaviourTree(build())
"""


@pytest.fixture
def grip(tmp_path, typed, monkeypatch):
    (tmp_path / "tree.xml").write_text(XML)
    (tmp_path / "mine.py").write_text(CODE)
    monkeypatch.delenv("PYTHONPATH", raising=False)
    monkeypatch.chdir(tmp_path)
    return typed


def test_an_xml_file_becomes_a_task_on_stdout(grip):
    done = grip("import", "tree.xml", "--from", "py_trees")
    assert done.returncode == 0
    assert loads(done.stdout).root.children["Retry"].times == 3
    assert "info[renamed] flow_succeed: was called 'flow.succeed'" in done.stderr


def test_a_factory_is_run_only_with_consent_and_its_task_runs(grip, tmp_path):
    refused = grip("import", "mine:build", "--from", "pytrees")
    assert refused.returncode == 1
    assert "if you trust it, say so with --execute" in refused.stderr
    done = grip("import", "mine:build", "--from", "pytrees", "--execute", "-o", "tasks")
    assert (done.returncode, done.stdout.split("\n")[0]) == (0, "task both: 3 nodes, 0 variables, 0 inputs, 2 outcomes")
    assert "a word of the module" not in done.stdout + done.stderr
    ran = grip("run", "tasks/both.yaml", "--robot", "fake")
    assert ran.stdout.startswith("success: success")


def test_a_tree_that_is_there_is_taken_too_and_foreign_files_are_kept(grip, tmp_path):
    assert loads(grip("import", "mine:tree", "--from", "pytrees", "--execute").stdout).root.kind == "parallel"
    (tmp_path / "both.yaml").write_text("mine")
    done = grip("import", "mine:tree", "--from", "pytrees", "--execute", "-o", "both.yaml")
    assert done.returncode == 1
    assert "would be overwritten" in done.stderr


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("mine:leaves", "mine: SystemExit: 3"),
        ("mine:nothing", "mine has no 'nothing' (there are: build, leaves)"),
        ("nowhere:build", "No module named 'nowhere'"),
        ("mine:XML:a", "names no tree: write module:function"),
        ("mine:py_trees.common.Status.SUCCESS", "makes no tree of py_trees but a Status"),
    ],
)
def test_what_gives_no_task_is_said_in_one_line(grip, where, said):
    done = grip("import", where, "--from", "pytrees", "--execute")
    assert done.returncode == 1
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_options_of_another_source_are_a_usage_error(grip):
    assert grip("import", "tree.xml", "--from", "pytrees", "--execute").returncode == 2
    assert grip("import", "tree.xml", "--from", "pytrees", "--machine", "a").returncode == 2


PROGRAM = """\
import operator
import py_trees
from py_trees.blackboard import Blackboard
from py_trees.common import Access, ComparisonExpression, Status


class Count(py_trees.behaviour.Behaviour):
    def __init__(self, board):
        super().__init__("count")
        self.board = self.attach_blackboard_client()
        self.board.register_key("count", Access.WRITE)

    def update(self):
        self.board.count += 1
        return Status.SUCCESS


class Same(py_trees.decorators.Decorator):
    def update(self):
        return self.decorated.status


def main():
    ready = py_trees.behaviours.CheckBlackboardVariableExists("there", "count")
    Blackboard.set("count", 0)
    same = Same("same", py_trees.composites.Sequence("work", False, [ready, Count(3)]))
    two = py_trees.behaviours.CheckBlackboardVariableValue("two", ComparisonExpression("count", 2, operator.eq))
    root = py_trees.composites.Sequence("root", True, [same, Count(4), two])
    py_trees.trees.BehaviourTree(root).tick_tock(100)


if __name__ == "__main__":
    main()
"""


def test_a_program_becomes_a_task_whose_kept_parts_share_its_variables(grip, tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    done = grip("import", "program.py", "--from", "pytrees", "--execute", "-o", "program.yaml")
    assert done.returncode == 1
    assert "'program:__main__' isn't in the project's `code:` list" in done.stdout
    refused = grip("run", "program.yaml")
    assert "unlisted-code" in refused.stderr
    (tmp_path / "grip.yaml").write_text("grip: 1\ncode: ['program:__main__']\n")
    task = loads((tmp_path / "program.yaml").read_text())
    assert task.root.children["same"].children["work"].children["there"].precondition == "count != null"
    assert task.root.children["count"].built_by == "program:__main__"
    for form in ("bt", "sm"):
        ran = grip("run", "program.yaml", "--robot", "fake", "--as", form)
        assert ran.stdout.startswith("success: success"), ran.stdout + ran.stderr
    assert grip("check", "program.yaml").returncode == 0
    assert "imports program:__main__" in grip("run", "program.yaml", "--no-code").stderr
    assert "imports and runs program.py" in grip("run", "program.py", "--no-code").stderr
