import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from work import calls_in

from grip_bt.base.errors import DocumentError
from grip_bt.task import dumps, load, loads, read

HEAD = "grip: 1\nname: a\n"
GOOD = HEAD + "root:\n  kind: sequence\n  children:\n    look: {node: sensor/eye, out: {points: cloud}}\n"


def refused(text):
    with pytest.raises(DocumentError) as caught:
        loads(text, "t.yaml")
    error = caught.value
    assert error.line is not None
    assert error.column is not None
    assert str(error).startswith(f"t.yaml:{error.line}:{error.column}: ")
    return error


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("", (1, 1), "empty"),
        ("# only a comment\n", (1, 1), "empty"),
        ("- a\n- b\n", (1, 1), "mapping"),
        ("just text", (1, 1), "mapping"),
        ("# c\n\n%YAML 1.2\n---\n" + GOOD, (3, 1), "YAML directives aren't supported"),
        (HEAD + 'doc: "\\UFFFFFFFF"', (3, 9), "not valid YAML"),
        (GOOD + "name: b\n", (7, 1), "duplicate key 'name'; it is already defined in line 2"),
        (GOOD + "doc: &a text\n", (7, 6), "anchors (&a)"),
        (GOOD + "doc: *a\n", (7, 6), "aliases (*a)"),
        (GOOD + "doc: !!str text\n", (7, 6), "tag"),
        (GOOD + "doc: !!python/object:os.system text\n", (7, 6), "tag"),
        (GOOD + "docs: text\n", (7, 1), "did you mean 'doc'?"),
        (GOOD + "---\ngrip: 1\n", (7, 1), "more than one YAML document"),
        (GOOD + "x-a: " + "9" * 100_000, (7, 6), "100000 characters"),
        (GOOD + "x-a: 99999999999999999999", (7, 6), "64 bits"),
        (GOOD + "x-a: 1e999", (7, 6), "larger than any float"),
        (GOOD + "x-a: {1: one}", (7, 7), "keys are text"),
        (GOOD + "x-a: [1, 2", (8, 1), "not valid YAML"),
        (GOOD + "\tx-a: 1", (7, 1), "not valid YAML"),
        (GOOD + "x-a: a\x00b", (7, 7), "not valid YAML"),
        (HEAD + "root: 3\n", (3, 1), "`node:` or `kind:`"),
        (HEAD + "root: {with: {a: 1}}\n", (3, 7), "`node:`"),
        (HEAD + "root: {node: a/b, x: 1}\n", (3, 19), "unknown key 'x'"),
        (HEAD + "root: {node: a/b, with_: {}}\n", (3, 19), "did you mean 'with'?"),
        (HEAD + "root: {kind: sequenc}\n", (3, 14), "did you mean 'sequence'?"),
        (HEAD + "root: {kind: [1]}\n", (3, 14), "unknown kind"),
        (HEAD + "root: {kind: sensor/eye}\n", (3, 14), "a leaf is written `node: sensor/eye`"),
        (HEAD + "root: {kind: retry, times: '3', child: {a: {node: a/b}}}\n", (3, 21), "integer"),
        (HEAD + "root: {kind: invert, child: {a: {node: a/b}, b: {node: a/b}}}\n", (3, 22), "at most 1"),
        (HEAD + "root: {kind: sequence, children: {a.b: {node: a/b}}}\n", (3, 35), "isn't a name"),
        (HEAD + "data: {a: 3}\nroot: {node: a/b}\n", (3, 11), "is a type"),
        (HEAD + "data: {a: {type: int, valu: 3}}\nroot: {node: a/b}\n", (3, 23), "'value'"),
        ("grip: 2\nname: a\nroot: {node: a/b}\n", (1, 7), "format 2 is newer than this version of GRIP reads (1)"),
        ("grip: 0\nname: a\nroot: {node: a/b}\n", (1, 7), "format 0 isn't supported; this version"),
        ("grip: true\nname: a\nroot: {node: a/b}\n", (1, 1), "a whole number, `grip: 1`, not True"),
        ("grip: 1.0\nname: a\nroot: {node: a/b}\n", (1, 1), "a whole number, `grip: 1`, not 1.0"),
        ("grip: 1\nroot: {node: a/b}\n", (1, 1), "'name' is missing"),
    ],
)  # fmt: skip
def test_a_wrong_text_is_refused_at_its_place(text, place, words):
    error = refused(text)
    assert words in str(error)
    assert (error.line, error.column) == place


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? ", "[{a: ", "a: [", "*a ", "&a ", "!a ", '"'])
def test_deep_or_endless_nesting_is_refused_with_bounded_work(opening):
    """However long it is: what reads it gives up at a depth, and looks no more than a line's length ahead."""
    assert calls_in(refused, HEAD + "x-a:\n  " + opening * 10_000) < 10_000_000


def test_all_faults_of_a_kind_are_reported_at_once():
    error = refused(HEAD + "root: {kind: sequence, children: {a: {nod: x}, b: {node: a/b, ind: {}}}}\n")
    assert "also 3:" in str(error)
    assert "'ind'" in str(error)


def test_bytes_that_are_no_text_are_refused_with_their_place(tmp_path):
    file = tmp_path / "t.yaml"
    file.write_bytes(b"grip: 1\nna\xff\xfe: a\n")
    with pytest.raises(DocumentError, match=r"t.yaml:2:3: not text in UTF-8"):
        load(file)
    with pytest.raises(DocumentError, match="No such file"):
        load(tmp_path / "none.yaml")
    with pytest.raises(DocumentError, match="directory"):
        load(tmp_path)
    with pytest.raises(DocumentError, match="'': a file's name is needed; this one is empty"):
        read("")


def test_a_file_too_large_is_refused_without_reading_it_all(tmp_path):
    file = tmp_path / "t.yaml"
    with file.open("wb") as f:
        f.truncate(10_000_000_000)
    with pytest.raises(DocumentError, match="larger than"):
        load(file)


def test_free_keys_are_kept_in_tasks_and_nodes():
    text = HEAD + "x-b: [1, {c: 2}]\nroot: {node: a/b, x-note: keep}\n"
    task = loads(text)
    assert task.x == {"x-b": [1, {"c": 2}]}
    assert task.root.x == {"x-note": "keep"}
    assert dumps(task) == text


def test_words_of_old_yaml_are_text():
    task = loads(HEAD + "x-a: [on, off, yes, no, 1_000, 12:30:00, 0o17, 0x1F, ~, 1e3]\nroot: {node: a/b}\n")
    assert task.x["x-a"] == ["on", "off", "yes", "no", "1_000", "12:30:00", 15, 31, None, 1000.0]


def test_the_example_of_the_documentation_is_a_task():
    text = (Path(__file__).parents[2] / "docs" / "task_format.md").read_text()
    example = text.split("```yaml\n")[1].split("```")[0]
    assert loads(example).name == "pick_one"


def test_positions_are_those_of_the_text():
    document = read(GOOD)
    assert document.position("/") == (3, 1)
    assert document.position("look") == (6, 5)
    assert document.position("look", ("out", "points")) == (6, 36)
    assert document.position("look", "node") == (6, 12)
    assert document.position("look", ("out", "nothing")) == (6, 30)
    assert document.position("", "name") == (2, 1)
    assert document.position("nowhere") is None
    assert document.position("look/inner") is None


def _outcome(text):
    try:
        loads(text)
    except DocumentError as error:
        return "refused" if error.line is None else "refused with a place"
    return "a task"


@settings(deadline=None, max_examples=300)
@given(st.text(st.sampled_from("ab: \n-[]{},#&*!|>'\"%?\t\\01.~\x85\ud7ff"), max_size=40) | st.text(max_size=40))
def test_any_text_is_a_task_or_is_refused_with_a_place(text):
    for whole in (text, HEAD + "root: {node: a/b}\nx-a: " + text):
        assert _outcome(whole) in ("a task", "refused with a place")


@settings(deadline=None, max_examples=100)
@given(st.binary(max_size=60))
def test_any_bytes_are_refused_with_a_place(data):
    with tempfile.NamedTemporaryFile() as file:
        file.write(data)
        file.flush()
        with pytest.raises(DocumentError) as caught:
            load(file.name)
    assert caught.value.line is not None
