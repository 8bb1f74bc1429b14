import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grip_bt.formats.draw import to_dot, to_mermaid, to_svg
from grip_bt.formats.draw.layout import Edge, Item, TreeItem, place, place_tree
from grip_bt.formats.draw.views import flow_figure, tree_figure
from grip_bt.task import Leaf, Sequence, StateMachine, Task, load, walk
from grip_bt.task.catalog import Catalog

EXAMPLE = load(Path(__file__).parents[3] / "examples" / "tasks" / "reactive_pick.yaml")
CATALOG = Catalog.builtin()
SVG = "{http://www.w3.org/2000/svg}"


def texts(svg):
    return [t.text for t in ElementTree.fromstring(svg).iter(f"{SVG}text")]


def overlap(a, b):
    return a.x < b.x + b.width and b.x < a.x + a.width and a.y < b.y + b.height and b.y < a.y + a.height


def inside(a, b):
    return a.x <= b.x and a.y <= b.y and b.x + b.width <= a.x + a.width and b.y + b.height <= a.y + a.height


@pytest.mark.parametrize("view", ["tree", "flow"])
def test_every_node_is_in_the_picture_by_name_and_kind(view):
    words = texts(to_svg(EXAMPLE, CATALOG, view))
    for path, node in walk(EXAMPLE.root):
        assert (EXAMPLE.name if path == "/" else path.rpartition("/")[2]) in words
        if isinstance(node, Leaf):
            assert node.node in words


@pytest.mark.parametrize("view", ["tree", "flow"])
def test_a_picture_needs_nothing_from_elsewhere_and_is_the_same_each_time(view):
    svg = to_svg(EXAMPLE, CATALOG, view)
    assert svg == to_svg(EXAMPLE, CATALOG, view)
    assert "http" not in svg.replace('xmlns="http://www.w3.org/2000/svg"', "")
    assert not re.search(r"<(script|style|image|foreignObject|use)\b", svg)


def test_words_of_a_task_are_never_markup():
    evil = "</text><script>&\"'"
    task = Task(grip=1, name=evil, root=Leaf.model_validate({"node": evil, "with": {"a": evil}, "doc": evil}))
    for view in ("tree", "flow"):
        root = ElementTree.fromstring(to_svg(task, CATALOG, view))
        assert not list(root.iter(f"{SVG}script"))
        assert "<script" not in to_mermaid(task, CATALOG, view)
        assert len(re.findall(r'(?<!\\)"', to_dot(task, CATALOG, view))) % 2 == 0


def test_boxes_of_the_tree_do_not_overlap_and_lie_in_the_picture():
    figure = tree_figure(EXAMPLE, CATALOG)
    for number, box in enumerate(figure.boxes):
        assert box.x >= 0
        assert box.y >= 0
        assert box.x + box.width <= figure.width
        assert box.y + box.height <= figure.height
        assert not any(overlap(box, other) for other in figure.boxes[:number])


def test_frames_of_the_flow_hold_their_children_and_nothing_else_overlaps():
    figure = flow_figure(EXAMPLE, CATALOG)
    for number, box in enumerate(figure.boxes):
        for other in figure.boxes[:number]:
            assert not overlap(box, other) or (other.frame and inside(other, box))


def test_every_edge_of_a_state_machine_is_drawn_with_its_label():
    machine = StateMachine.model_validate(
        {
            "kind": "state_machine",
            "initial": "a",
            "outcomes": {"done": "success", "lost": "failure"},
            "children": {
                "a": {"node": "x/a", "on": {"success": "b", "failure": "a"}},
                "b": {"node": "x/b", "on": {"success": "done", "failure": "a", "failure.no_ik": "lost"}},
            },
        }
    )
    figure = flow_figure(Task(grip=1, name="t", root=machine), CATALOG)
    assert sorted(line.label for line in figure.lines) == [
        "",
        "failure",
        "failure",
        "failure.no_ik",
        "success",
        "success",
    ]
    assert {(pill.name, pill.meaning) for pill in figure.pills} == {
        ("done", "success"),
        ("lost", "failure"),
        ("", "start"),
    }


def twigs():
    return st.recursive(
        st.builds(TreeItem, st.floats(10, 80)),
        lambda below: st.builds(TreeItem, st.floats(10, 80), st.lists(below, max_size=4)),
        max_leaves=25,
    )


@settings(deadline=None)
@given(twigs())
def test_a_tidy_tree_keeps_order_and_distance_in_each_column(root):
    place_tree(root, 5.0)
    column = [root]
    while column:
        for upper, lower in zip(column, column[1:], strict=False):
            assert upper.y + upper.height / 2 + 5.0 <= lower.y - lower.height / 2 + 1e-6
        for twig in column:
            if twig.below:
                assert twig.y == pytest.approx(twig.below[0].y)
        column = [child for twig in column for child in twig.below]


def test_every_parent_is_met_before_its_children():
    children = {f"step{i}": Leaf(node="flow/wait") for i in range(200)}
    figure = tree_figure(Task(grip=1, name="t", root=Sequence(kind="sequence", children=children)), CATALOG)
    root, first = figure.boxes[0], figure.boxes[1]
    assert root.y + root.height / 2 == pytest.approx(first.y + first.height / 2)
    assert all(len(line.points) == 4 for line in figure.lines), "by right angles, not by curves of a thousand pixels"


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.data())
def test_layers_never_overlap_and_edges_between_ranks_have_room(data):
    names = [f"n{i}" for i in range(data.draw(st.integers(1, 8)))]
    nodes = {n: Item(data.draw(st.floats(10, 90)), 30.0) for n in names}
    pairs = st.tuples(st.sampled_from(names), st.sampled_from(names)).filter(lambda p: p[0] != p[1])
    ends = data.draw(st.lists(pairs, max_size=14, unique=True)) if len(names) > 1 else []
    edges = [Edge(a, b, (20.0, 12.0)) for a, b in ends]
    placed = place(nodes, edges, [], 8.0, 10.0)
    items = [*nodes.values(), *(bend for edge in edges for bend in edge.bends)]
    for rank in {item.rank for item in items}:
        row = sorted((i for i in items if i.rank == rank), key=lambda i: i.x)
        for left, right in zip(row, row[1:], strict=False):
            assert left.x + left.width / 2 + 8.0 <= right.x - right.width / 2 + 1e-6
    for item in items:
        assert item.x - item.width / 2 >= -1e-6
        assert item.x + item.width / 2 <= placed.width + 1e-6


@pytest.mark.parametrize("view", ["tree", "flow"])
def test_dot_and_mermaid_name_every_node(view):
    dot, mermaid = to_dot(EXAMPLE, CATALOG, view), to_mermaid(EXAMPLE, CATALOG, view)
    for path, _ in walk(EXAMPLE.root):
        assert f'"{path}" [' in dot
    assert dot.count("{") == dot.count("}")
    assert mermaid.count("subgraph ") == len(re.findall(r"^ *end$", mermaid, re.MULTILINE))
    assert len(re.findall(r"\bn\d+\[", mermaid)) == sum(1 for _ in walk(EXAMPLE.root))
