import pytest
from hypothesis import given
from hypothesis import strategies as st

from grip_bt.base.errors import DocumentError
from grip_bt.task import read_text
from grip_bt.task.edit import Move, Remove, Rename, Unwrap, Wrap, apply, apply_to_document
from grip_bt.task.edit.steps import backwards
from grip_gui.editing.layout import Layout, layout_path, read_layout, write_layout

paths = st.from_regex(r"\A[a-z_][a-z /_-]{0,8}\Z") | st.just("/")
spots = st.dictionaries(paths, st.tuples(st.integers(-(10**6), 10**6), st.integers(-(10**6), 10**6)), max_size=4)
TASK = read_text(
    "grip: 1\nname: a\nroot:\n  kind: sequence\n  children:\n"
    "    pick: {kind: sequence, children: {grasp: {node: a/b}}}\n"
    "    rest: {node: a/c}\n"
).task
LAYOUT = Layout().pin("flow", "pick/grasp", (64, 96)).pin("flow", "pick", (3, -5)).pin("tree", "rest", (0, 8))


@given(st.fixed_dictionaries({}, optional={"flow": spots, "tree": spots}))
def test_a_written_layout_is_read_back_equal_and_writing_is_canonical(pinned):
    layout = Layout({view: some for view, some in pinned.items() if some})
    text = write_layout(layout)
    assert read_layout(text) == layout
    assert write_layout(read_layout(text)) == text


def test_positions_are_on_the_grid_and_nodes_stand_sorted_one_a_line():
    assert write_layout(LAYOUT) == ("flow:\n  pick: [0, -8]\n  pick/grasp: [64, 96]\ntree:\n  rest: [0, 8]\n")
    assert LAYOUT.pin("flow", "pick", None).pinned["flow"] == {"pick/grasp": (64, 96)}
    assert write_layout(Layout()) == ""


def test_entries_that_arent_known_are_kept_or_passed_over():
    text = "flow: {a: [1, 2], b: [1], c: [x, 2], d: null, e: [1.5, 2]}\nfolded: [a]\nzoom: {level: 2}\ntree: [1]\n"
    layout = read_layout(text)
    assert layout.pinned == {"flow": {"a": (1, 2)}}
    assert layout.unknown == {"folded": ["a"], "zoom": {"level": 2}}
    assert "zoom: {level: 2}" in write_layout(layout)
    assert read_layout("- a\n") == Layout()
    with pytest.raises(DocumentError):
        read_layout("flow: [")


@pytest.mark.parametrize(
    ("command", "flow"),
    [
        (Rename(path="pick", name="take"), {"take": (0, -8), "take/grasp": (64, 96)}),
        (Remove(path="pick"), {}),
        (Move(path="rest", parent="pick"), {"pick": (0, -8), "pick/grasp": (64, 96)}),
        (
            Wrap(paths=("pick",), kind="invert", name="no"),
            {"no/pick": (0, -8), "no/pick/grasp": (64, 96)},
        ),
        (
            Wrap(paths=("/",), kind="invert", name="all"),
            {"all/pick": (0, -8), "all/pick/grasp": (64, 96)},
        ),
        (Unwrap(path="pick"), {"grasp": (64, 96)}),
    ],
)
def test_the_layout_follows_an_edit_of_the_task(command, flow):
    done = apply(TASK, command)
    after = LAYOUT.after(done.steps)
    assert after.pinned["flow"] == flow


def test_undoing_an_edit_leads_what_is_left_of_the_layout_back():
    document = read_text("grip: 1\nname: a\nroot:\n  kind: sequence\n  children: {pick: {node: a/b}}\n")
    layout = Layout().pin("flow", "pick", (8, 8)).pin("flow", "/", (0, 0))
    done = apply_to_document(document, Wrap(paths=("/",), kind="invert", name="all"))
    moved = layout.after(done.steps)
    assert moved.pinned["flow"] == {"all/pick": (8, 8), "all": (0, 0)}
    assert moved.after(backwards(done.steps)) == layout


def test_a_layout_stands_beside_its_task(tmp_path):
    file = layout_path(tmp_path / "pick.yaml")
    assert file.name == "pick.layout.yaml"
