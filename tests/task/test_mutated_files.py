"""Whatever a file holds: reading and checking it gives a task or a typed error, in bounded time and memory.

A sample is in the suite. `GRIP_FUZZ_FILES` says how many files, `GRIP_FUZZ_SEED` where to begin; 10,000 take five
minutes.
"""

import json
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from mutations import KINDS, mutant
from ruamel.yaml import YAML

from grip_bt.base.errors import DocumentError
from grip_bt.base.yaml.tree import MAX_VALUES
from grip_bt.task import Task, dumps, read_text
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate

FILES = int(os.environ.get("GRIP_FUZZ_FILES", "200"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
REPO = Path(__file__).parents[2]
HEAD = "grip: 1\nname: a\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with the files that are mutated: the tasks of the project and of its tests."""
    folder = tmp_path_factory.mktemp("mutants")
    tasks = [*(REPO / "examples" / "tasks").glob("*.yaml"), *(REPO / "tests" / "golden" / "standalone").glob("*.yaml")]
    texts = [path.read_text() for path in sorted(tasks)]
    for path in sorted((REPO / "tests" / "parity" / "cases").glob("*.yaml")):
        texts.append(dumps(Task.model_validate(YAML(typ="safe").load(path)["task"])))
    for number, text in enumerate(texts):
        (folder / f"{number:03}.base").write_text(text)
    return folder


def test_every_mutated_file_gives_a_task_or_a_typed_error_in_time(folder):
    command = [sys.executable, str(Path(__file__).with_name("mutated_worker.py")), str(folder), str(FIRST), str(FILES)]
    paths = os.pathsep.join([str(REPO / "tests"), os.environ.get("PYTHONPATH", "")])
    env = {**os.environ, "PYTHONPATH": paths}
    done = subprocess.run(command, capture_output=True, text=True, timeout=600 + FILES, env=env)
    facts = [json.loads(line) for line in done.stdout.splitlines()]
    wrong = [fact for fact in facts if fact["result"] not in ("valid", "invalid", "refused")]
    assert not wrong, wrong[:3]
    assert len(facts) == FILES, done.stderr[-2000:]
    results = Counter(fact["result"] for fact in facts)
    slowest, largest = max(fact["seconds"] for fact in facts), max(fact["megabytes"] for fact in facts)
    sys.stdout.write(f"\n{FILES} files: {dict(results)}; at most {slowest:.2f} s, {largest:.0f} MB in all\n")
    assert {fact["kind"] for fact in facts} == set(KINDS)
    assert results["refused"] > results["invalid"] > 0


def test_a_seed_gives_one_file():
    assert mutant(7, [HEAD]) == mutant(7, [HEAD])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x-a: [" + "1, " * MAX_VALUES + "1]\n", f"the file has more than {MAX_VALUES} values; move parts of it into"),
        ("#" + " c" * 100_000 + "\nx-a:\tb\x85\n", r":4:7: not valid YAML: the character U\+0085"),
        ("#" + " c" * 100_000 + "\nx-a: [\n", r":\d+:1: not valid YAML: .*did not find expected ',' or ']'"),
        ("#" + " c" * 100_000 + "\nx-a: *b\n", r":4:6: YAML aliases \(\*b\)"),
        ("#" + " c" * 700_000 + "\n", "larger than 1250000 characters"),
    ],
)
def test_what_is_too_large_or_wrong_in_a_large_file_is_refused_with_its_place(text, words):
    with pytest.raises(DocumentError, match=words):
        read_text(f"{HEAD}{text}root: {{node: a/b}}\n", "t.yaml")


def tasks_of_10_000(per_node):
    """Return the text of a task of 9,901 leaves in a sequence, each as `per_node` says."""
    return f"{HEAD}root:\n  kind: sequence\n  children:\n" + "".join(per_node(n) for n in range(9_901))


def test_10_000_nodes_with_a_parameter_and_a_comment_each_are_read_and_found_right():
    text = tasks_of_10_000(
        lambda n: f"    # what step {n} is for\n    s{n}: {{node: flow/wait, with: {{seconds: {n}}}}}\n"
    )
    document = read_text(text, "t.yaml")
    assert validate(document.task, Catalog.builtin(), document).issues == ()
    assert document.position("s9900", ("with", "seconds")) == (2 + 3 + 2 * 9_901, 37)


def test_what_is_wrong_in_the_last_of_10_000_nodes_is_said_with_its_place():
    text = tasks_of_10_000(lambda n: f"    s{n}: {{{'node' if n < 9_900 else 'nod'}: flow/wait}}\n")
    with pytest.raises(DocumentError, match=rf"t.yaml:{2 + 3 + 9_901}:12: [\s\S]*'nod'"):
        read_text(text, "t.yaml")


def test_10_000_different_unknown_nodes_are_all_named():
    document = read_text(tasks_of_10_000(lambda n: f"    s{n}: {{node: flow/wai{n}}}\n"), "t.yaml")
    issues = validate(document.task, Catalog.builtin(), document).issues
    assert [issue.line for issue in issues] == [2 + 3 + 1 + n for n in range(9_901)]
    assert {issue.code for issue in issues} == {"unknown-node"}
    assert "did you mean 'flow/wait'" in issues[0].message


def test_a_type_longer_than_any_is_refused_at_once():
    from grip_bt.base.types import parse_type

    with pytest.raises(ValueError, match="is longer than 30000 characters, which no type is"):
        parse_type("list[" * 100_000)
