import re
import sys

import pytest

import grip_bt.base.values
from grip_bt.base.errors import DocumentError, ImplementationError, UnknownNameError
from grip_bt.base.types import VALUES
from grip_bt.base.values import JointState, Pose
from grip_bt.task.catalog import (
    Catalog,
    Manifest,
    check_value,
    find_manifests,
    is_assignable,
    load_implementation,
    parse_type,
    read_manifests,
)


def manifest(id="demo/one", implementation="collections:OrderedDict"):
    return Manifest(id=id, doc="d", implementation=implementation)


def test_the_names_of_value_types_are_those_of_the_values_package():
    assert set(VALUES) == set(grip_bt.base.values.__all__)


@pytest.mark.parametrize(
    "text",
    ["Pose", "int", "Any", "list[Grasp]", "dict[str, list[float | None]]", "geometry_msgs/msg/Pose", "Pose | None"],
)
def test_a_type_is_written_as_it_was_read(text):
    assert str(parse_type(text)) == text
    assert parse_type(f" {text} ") == parse_type(text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Psoe", "did you mean 'Pose'"),
        ("list[Grsp]", "did you mean 'Grasp'"),
        ("", "unknown type"),
        ("list[int", "isn't a type"),
        ("int]", "isn't a type"),
        ("int | str", "only union"),
        ("dict[int, int]", "dict[str, T]"),
        ("list[" * 30 + "int" + "]" * 30, "nested deeper"),
        ("os.system", "unknown type"),
        ("é", "unknown type"),
    ],
)
def test_what_is_no_type_is_refused_with_a_hint(text, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        parse_type(text)


@pytest.mark.parametrize(
    ("source", "target", "fits"),
    [
        ("Pose", "Pose", True),
        ("Pose", "Grasp", False),
        ("int", "float", True),
        ("float", "int", False),
        ("bool", "int", False),
        ("Pose", "Pose | None", True),
        ("Pose | None", "Pose", False),
        ("None", "Pose | None", True),
        ("list[int]", "list[float]", True),
        ("list[Pose]", "list[Grasp]", False),
        ("list", "list[Pose]", True),
        ("dict[str, int]", "dict[str, float | None]", True),
        ("list[int]", "dict[str, int]", False),
        ("Any", "Pose", True),
        ("list[Any]", "list[Pose]", True),
        ("a_msgs/msg/A", "a_msgs/msg/A", True),
        ("a_msgs/msg/A", "a_msgs/msg/B", False),
    ],
)
def test_what_may_flow_where(source, target, fits):
    assert is_assignable(source, target) is fits


@pytest.mark.parametrize(
    ("type_", "value", "reason"),
    [
        ("float", 1, None),
        ("float", True, "is True, a bool, not a float"),
        ("int", 1.0, "is 1.0, a float, not a int"),
        ("Pose | None", None, None),
        ("Pose", None, "is None, a NoneType, not a Pose"),
        ("list[list[float]]", [[1, 2.5], []], None),
        ("list[list[float]]", [[1], [2, "x"]], "[1][1] is 'x', a str, not a float"),
        ("dict[str, int]", {"a": 1, "b": None}, "['b'] is None, a NoneType, not a int"),
        ("dict[str, int]", {1: 1}, "the key 1 of it is a int, not a str"),
        ("Any", object, None),
        ("a_msgs/msg/A", 3, "is 3, a int, not a a_msgs/msg/A"),
    ],
)
def test_why_a_value_is_not_of_a_type(type_, value, reason):
    assert check_value(type_, value) == reason


def test_values_are_recognised_by_class():
    assert check_value("Pose", Pose()) is None
    assert check_value("list[Pose]", (Pose(),)) is None
    assert check_value("JointState", Pose()) is not None
    assert check_value("JointState", JointState((), [])) is None


def test_the_built_in_catalogue_is_readable_and_every_implementation_is_there():
    catalog = Catalog.builtin()
    assert len(catalog.ids()) > 10
    for each in catalog:
        assert isinstance(load_implementation(each), type), each.id


def test_an_unknown_node_is_an_error_that_names_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'demo/one'"):
        Catalog([manifest()]).get("demo/on", "attempt/look")


def test_a_later_manifest_replaces_but_two_at_once_are_an_error():
    mock = manifest(implementation="collections:Counter")
    assert Catalog([manifest()]).with_manifests([mock]).get("demo/one") is mock
    with pytest.raises(DocumentError, match="two nodes are called 'demo/one'"):
        Catalog([manifest(), mock])


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("- id: demo/a\n  doc: d\n  implementaton: a:B\n", (3, 3), "did you mean 'implementation'"),
        ("id: A\ndoc: d\nimplementation: a:B\n", (1, 1), "id"),
        ("id: demo/a\ndoc: d\n", (1, 1), "'implementation' is missing"),
        ("id: demo/a\ndoc: d\nimplementation: a:B\ninputs:\n  p: {type: Psoe}\n", (5, 7), "did you mean 'Pose'"),
        ("id: demo/a\ndoc: d\nimplementation: a:B\ninputs: {p: {typ: Pose}}\n", (4, 14), "did you mean 'type'"),
        (
            "id: demo/a\ndoc: d\nimplementation: a:B\noutputs: {p: {type: Pose, on: [sucess]}}\n",
            (1, 1),
            "did you mean 'success'",
        ),
        ("- 3\n", (1, 3), "a manifest is a mapping"),
        ("[1", (2, 1), "not valid YAML"),
    ],
)
def test_a_wrong_manifest_is_refused_at_its_place(text, place, words, tmp_path):
    file = tmp_path / "manifest.yaml"
    file.write_text(text)
    with pytest.raises(DocumentError) as caught:
        read_manifests(file)
    assert words in str(caught.value)
    assert (caught.value.line, caught.value.column) == place


def test_a_manifest_in_a_folder_names_its_file_absolutely_and_its_class_is_loaded(tmp_path):
    for name in ("a", "b"):
        folder = tmp_path / name / "node"
        folder.mkdir(parents=True)
        (folder / "manifest.yaml").write_text(f"id: component/{name}\ndoc: d\nimplementation: leaf.py:Leaf\n")
        (folder / "leaf.py").write_text(f"class Leaf:\n    name = {name!r}\n")
    found = find_manifests(tmp_path)
    assert [m.id for m in found] == ["component/a", "component/b"]
    assert found[0].implementation == f"{tmp_path.resolve()}/a/node/leaf.py:Leaf"
    assert [load_implementation(m).name for m in found] == ["a", "b"]
    assert load_implementation(found[0]) is load_implementation(found[0])


@pytest.mark.parametrize(
    ("implementation", "words"),
    [
        ("no.such.module:A", "there is no module 'no'"),
        ("grip_bt.task.catalog.nothing:A", "there is no module 'grip_bt.task.catalog.nothing'"),
        ("collections", "package.module:Class"),
        ("collections:1x", "package.module:Class"),
        ("collections:namedtuple", "not a class"),
        ("/no/such/leaf.py:A", "no such file"),
        ("{tmp}/needs.py:A", "needs 'missing_thing'"),
        ("{tmp}/broken.py:A", "raised ZeroDivisionError"),
    ],
)
def test_an_implementation_that_cannot_be_loaded_says_why(implementation, words, tmp_path):
    (tmp_path / "needs.py").write_text("import missing_thing\n")
    (tmp_path / "broken.py").write_text("1 / 0\n")
    with pytest.raises(ImplementationError, match="^node demo/one: ") as caught:
        load_implementation(manifest(implementation=implementation.format(tmp=tmp_path)))
    assert words in str(caught.value)
    assert not [name for name in sys.modules if name.startswith("grip_node_") and "broken" in name]


def test_a_missing_class_names_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'OrderedDict'"):
        load_implementation(manifest(implementation="collections:OrderdDict"))
