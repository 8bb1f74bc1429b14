"""Nodes in Python files are found without being run, and what they are when run is what was found."""

from __future__ import annotations

import random
import textwrap
from pathlib import Path

import pytest

import grip_bt as grip
from grip_bt.base.errors import DocumentError
from grip_bt.nodes import Leaf
from grip_bt.nodes.function import FunctionLeaf
from grip_bt.task.catalog import find_python_nodes, load_implementation, read_python_nodes

SHELF = Path(__file__).parents[3] / "examples" / "nodes" / "shelf.py"
HEAD = "import grip_bt as grip\nfrom grip_bt.base.values import Grasp, PointCloud\n"


def found(tmp_path, text, head=HEAD):
    (tmp_path / "mine.py").write_text(head + textwrap.dedent(text))
    return {manifest.id: manifest for manifest in find_python_nodes(tmp_path)}


def test_a_function_is_a_node_by_its_annotations(tmp_path):
    made = found(
        tmp_path,
        '''
        @grip.leaf("my/tall", outputs={"count": int, "best": Grasp | None}, codes=("odd",))
        def tall(cloud: PointCloud, near: "list[Grasp]" = None, *, limit: float = -0.5, name: str) -> int:
            """Count what is tall."""
            raise SystemExit("mustn't be run")
        ''',
    )["my/tall"]
    assert made.doc == "Count what is tall."
    assert made.implementation == f"{tmp_path / 'mine.py'}:tall"
    assert {n: (p.type, p.required) for n, p in made.inputs.items()} == {
        "cloud": ("PointCloud", True),
        "near": ("list[Grasp]", False),
    }
    assert (made.parameters["limit"].default, made.parameters["name"].required) == (-0.5, True)
    assert {n: p.type for n, p in made.outputs.items()} == {"count": "int", "best": "Grasp | None"}
    assert made.codes == ("odd",)


def test_a_class_is_a_node_by_its_marked_annotations(tmp_path):
    made = found(
        tmp_path,
        """
        from typing import Optional

        @grip.leaf("my/weigh", doc="Weigh.", outcomes={"heavy": "success", "light": "failure"})
        class Weigh(grip.Leaf):
            scales: grip.Input[str]
            extra: grip.Input[Optional[float]] = None
            limit: grip.Param[float] = 2.0
            weight: grip.Output[float]
            seen: int = 0
        """,
    )["my/weigh"]
    assert {n: (p.type, p.required) for n, p in made.inputs.items()} == {
        "scales": ("str", True),
        "extra": ("float | None", False),
    }
    assert set(made.parameters) == {"limit"}
    assert set(made.outputs) == {"weight"}
    assert made.outcomes == {"heavy": "success", "light": "failure"}


@pytest.mark.parametrize(
    "head",
    [
        "from grip_bt import leaf\n@leaf",
        "from grip_bt import leaf as node\n@node",
        "from grip_bt.nodes.function import leaf\n@leaf",
        "import grip_bt\n@grip_bt.leaf",
    ],
)
def test_the_decorator_is_known_by_what_was_imported(tmp_path, head):
    assert set(found(tmp_path, "('my/node')\ndef f() -> None: ...\n", head)) == {"my/node"}


def test_other_decorators_of_that_name_are_not_ours(tmp_path):
    assert not found(tmp_path, "from trees import leaf\n@leaf('my/node')\ndef f(): ...\n", "")


def test_nothing_is_run_to_find_it(tmp_path):
    mark = tmp_path / "was_run"
    found(tmp_path, f"open({str(mark)!r}, 'w')\n@grip.leaf('my/node')\ndef f(): ...\n")
    assert not mark.exists()


def test_tests_hidden_and_private_files_are_left_out(tmp_path):
    for name in ("test_x.py", "_x.py", ".hidden/x.py", "sub/x.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(HEAD + f"@grip.leaf('my/{Path(name).stem}')\ndef f(): ...\n")
    assert [manifest.id for manifest in find_python_nodes(tmp_path)] == ["my/x"]


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("@grip.leaf\ndef f(): ...\n", 3, "needs the node's id"),
        ("@grip.leaf()\ndef f(): ...\n", 3, "needs the node's id"),
        ("@grip.leaf('Bad Id')\ndef f(): ...\n", 3, "id: "),
        ("@grip.leaf('my/f', output={'a': int})\ndef f(): ...\n", 3, "did you mean 'outputs'"),
        ("@grip.leaf('my/f')\ndef f(cloud): ...\n", 4, "'cloud' needs an annotation"),
        ("@grip.leaf('my/f')\ndef f(cloud: PointClod): ...\n", 4, "did you mean 'PointCloud'"),
        ("@grip.leaf('my/f')\ndef f(*clouds: PointCloud): ...\n", 4, "fixed number of arguments"),
        ("@grip.leaf('my/f')\ndef f(*, a: int = make()): ...\n", 4, "a literal is needed"),
        ("@grip.leaf('my/f')\ndef f(*, a: int = 'x'): ...\n", 4, "the default is 'x'"),
        ("@grip.leaf('my/f', outcomes={'a': 'maybe'})\ndef f(): ...\n", 3, "outcomes"),
        ("@grip.leaf('my/f')\ndef f(: ...\n", 4, "isn't Python"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path, text, line, says):
    with pytest.raises(DocumentError, match=says) as caught:
        found(tmp_path, text)
    assert caught.value.line == line


def test_mutated_files_are_read_or_refused_never_worse(tmp_path):
    rng, source = random.Random(0), SHELF.read_text()
    file = tmp_path / "mutated.py"
    for _ in range(300):
        text = list(source)
        for _ in range(rng.randint(1, 5)):
            at = rng.randrange(len(text))
            text[at : at + rng.randint(0, 8)] = rng.choice(["", "(", "\n", "*", "0", "'", "\x00", "lambda: 0", "[int]"])
        file.write_text("".join(text))
        try:
            read_python_nodes(file)
        except DocumentError:
            pass


@pytest.mark.parametrize("manifest", read_python_nodes(SHELF), ids=lambda m: m.id)
def test_what_was_found_is_what_the_code_makes_when_it_is_run(manifest):
    made = load_implementation(manifest)
    assert issubclass(made, Leaf)
    if issubclass(made, FunctionLeaf):
        face = made.face
        assert (face.id, face.doc, face.codes, face.outcomes) == (
            manifest.id,
            manifest.doc,
            manifest.codes,
            manifest.outcomes,
        )
        assert (face.inputs, face.parameters, face.outputs) == (manifest.inputs, manifest.parameters, manifest.outputs)
    else:
        assert all(hasattr(made, port) for port in (*manifest.inputs, *manifest.parameters, *manifest.outputs))


def test_a_class_that_is_no_leaf_and_a_port_with_a_leafs_own_name_are_refused():
    with pytest.raises(TypeError, match="grip_bt.Leaf"):

        @grip.leaf("my/f")
        class NoLeaf:
            pass

    with pytest.raises(TypeError, match="attribute 'name' already"):

        @grip.leaf("my/g")
        class Named(grip.Leaf):
            name: grip.Input[str]
