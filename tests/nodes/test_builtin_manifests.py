"""The manifests and the classes behind them say the same."""

import ast
import inspect
import re
from pathlib import Path
from runpy import run_path

import pytest
import yaml

from grip_bt.base.types import check_value, parse_type
from grip_bt.nodes import Leaf, OperationLeaf
from grip_bt.nodes.control import Control
from grip_bt.task import load
from grip_bt.task.catalog import Catalog
from grip_bt.task.catalog.catalog import load_implementation
from grip_bt.task.catalog.ros_config import sensor_manifest
from grip_bt.task.model import Leaf as LeafNode
from grip_bt.task.model import walk

ROOT = Path(__file__).parents[2]
MANIFESTS = [*Catalog.builtin(), sensor_manifest("overhead")]


CONTROLS = [m for m in MANIFESTS if issubclass(load_implementation(m), Control)]


@pytest.fixture(params=[m for m in MANIFESTS if m not in CONTROLS], ids=lambda m: m.id)
def manifest(request):
    return request.param


@pytest.mark.parametrize("control", CONTROLS, ids=lambda m: m.id)
def test_a_control_node_names_each_of_its_ports_and_settings(control):
    text = source_of(control).replace('f"case_{i + 1}"', " ".join(f'"case_{i}"' for i in range(1, 7)))
    named = {p for p in (*control.parameters, *control.inputs, *control.outputs) if len(p) > 1}  # `a` to `h`: scripts
    named -= set(control.settings.values())
    assert {port for port in named if f'"{port}"' not in text and f"{port}=" not in text} == set()
    assert {s for s in control.settings if f'settings["{s}"]' not in text} == set()


def source_of(manifest):
    """Return the text of the class and of those it inherits from, without the shared base."""
    classes = [c for c in load_implementation(manifest).__mro__ if c.__module__.startswith("grip_bt.nodes")]
    return "\n".join(inspect.getsource(c) for c in classes if c.__module__ != "grip_bt.nodes.leaf")


def test_the_implementation_is_a_leaf(manifest):
    assert issubclass(load_implementation(manifest), Leaf)


def test_a_leaf_reads_exactly_its_declared_inputs(manifest):
    assert set(re.findall(r'self\.read\("(\w+)"\)', source_of(manifest))) == set(manifest.inputs)


def test_a_leaf_uses_exactly_its_declared_parameters(manifest):
    used = set(re.findall(r'(?:params|\bp)\["(\w+)"\]', source_of(manifest)))
    assert used == set(manifest.parameters)


def test_a_leaf_writes_exactly_its_declared_outputs(manifest):
    text = source_of(manifest)
    calls = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
    ends = [call for call in calls if ast.unparse(call.func) == "self.end"]
    written = {word.arg for call in ends for word in call.keywords if word.arg}
    written |= set(re.findall(r'(?:points|outputs) = \{"(\w+)"', text))
    leaf = load_implementation(manifest)
    if (
        issubclass(leaf, OperationLeaf)
        and leaf.start is not OperationLeaf.start
        and leaf.finish is OperationLeaf.finish
    ):
        written |= set(manifest.outputs) if len(manifest.outputs) == 1 else set()  # the operation's result
    assert written == set(manifest.outputs)


def test_every_default_is_of_its_parameters_type(manifest):
    for name, parameter in manifest.parameters.items():
        if not parameter.required:
            assert check_value(parse_type(parameter.type), parameter.default) is None, name


def test_a_leaf_that_may_fail_says_with_which_codes(manifest):
    assert bool(manifest.codes) == ("failure" in manifest.outcomes.values())


def test_every_leaf_and_port_is_documented(manifest):
    assert manifest.doc.endswith(".")
    ports = {**manifest.parameters, **manifest.inputs, **manifest.outputs}
    assert all(port.doc for port in ports.values()), [n for n, p in ports.items() if not p.doc]


def test_the_example_task_binds_only_what_the_manifests_declare():
    known = {m.id: m for m in MANIFESTS}
    for path, node in walk(load(ROOT / "examples/tasks/reactive_pick.yaml").root):
        if isinstance(node, LeafNode) and not node.node.startswith("component/"):
            manifest = known[node.node]
            assert set(node.with_) <= set(manifest.parameters), path
            assert set(node.in_) <= set(manifest.inputs), path
            assert set(node.out) <= set(manifest.outputs), path
            codes = {edge.partition(".")[2] for edge in node.on if "." in edge}
            assert codes <= set(manifest.codes), path


def test_the_reference_pages_are_as_new_as_the_manifests():
    made = run_path(str(ROOT / "tools" / "node_reference.py"))["builtin_reference"]()
    pages = {name: (ROOT / "docs" / name).read_text(encoding="utf-8") for name in made}
    assert pages == made, "run: python tools/node_reference.py docs"


def test_its_example_of_each_group_fits_the_manifests():
    known = {m.id: m for m in (*MANIFESTS, sensor_manifest("NAME"))}
    examples = run_path(str(ROOT / "tools" / "node_reference.py"))["EXAMPLES"]
    assert set(examples) == {id.split("/")[0] for id in known}
    for group, text in examples.items():
        node = yaml.safe_load(text)
        manifest = known[node["node"]]
        assert manifest.id.startswith(f"{group}/")
        assert set(node.get("with", {})) <= set(manifest.parameters), text
        assert {name for name, port in manifest.inputs.items() if port.required} <= set(node.get("in", {})), text
        assert set(node.get("in", {})) <= set(manifest.inputs), text
        assert set(node.get("out", {})) <= set(manifest.outputs), text
