"""What is YAML to us: libyaml's parser and PyYAML's own give the same tree, and refuse the same at the same line."""

from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.base.errors import DocumentError
from grip_bt.base.yaml import tree
from grip_bt.base.yaml.tree import parse
from grip_bt.task import catalog, loads

bits = st.lists(
    st.sampled_from(
        ["a: ", "b:", "c: d", "\n", "\n  ", "\n    ", "\n\n", "\n\n\n", "- ", "  ", "|", "|-", "|+", ">", ">-", "text",
         "# c", "  # c", "\n# c", "{a: 1}", "{a: ,b}", "[1, 2]", "''", '"q"', '"\\u00e9"', "é", "!", "&", "*", "%", "@",
         "`", ",", "]", "}", "[", "{", "'", '"', "\\", "1e5", "0x1F", "~", "on", "\r\n", "\r", "\x85", "\ufeff",
         "\u2028", "--- ", "...", "<<: "]
    ),
    max_size=14,
).map("".join)  # fmt: skip
around = st.sampled_from(
    ["{}", "a: {}", "a:\n  {}\nb: 1", "a: {b: {}}", "a: |\n  {}", "a: >\n  {}\n b\n", "- {}", "- a: {}\n  b: 1\n- c",
     "[a, {}]", "- - {}\n- b: {}\n"]
)  # fmt: skip


def read_by(parser, text):
    """Return the tree that a parser's events give, or None."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tree, "_Parser", parser)
        try:
            return repr(parse(text))
        except DocumentError:
            return None


@settings(deadline=None, max_examples=400)
@given(bits, around)
def test_both_parsers_give_the_same_tree_places_included(bit, around):
    text = around.replace("{}", bit)
    by_libyaml, by_python = read_by(tree._Parser, text), read_by(yaml.SafeLoader, text)
    if by_libyaml is not None and by_python is not None:
        assert by_libyaml == by_python


def test_built_in_manifests_and_examples_are_read_alike_without_libyaml():
    files = sorted((Path(catalog.__file__).parent / "builtin").glob("*.yaml"))
    files += sorted((Path(__file__).parents[2] / "examples" / "tasks").glob("*.yaml"))
    assert len(files) > 10
    for file in files:
        read = read_by(tree._Parser, file.read_text())
        assert read is not None, file
        assert read == read_by(yaml.SafeLoader, file.read_text()), file


@pytest.mark.parametrize("word", ["with_", "in_", "x"])
def test_a_fields_own_name_is_no_key_of_a_file(word):
    with pytest.raises(DocumentError, match=f"unknown key '{word}'"):
        loads(f"grip: 1\nname: a\nroot: {{node: a/b, {word}: {{a: b}}}}\n")


@pytest.mark.parametrize("sign", ["\x07", "\x85", "\u2028", "\u2029", "\ufeff", "\ud800"])
def test_characters_that_editors_and_parsers_take_differently_are_refused_with_their_place(sign):
    with pytest.raises(
        DocumentError, match=rf"t.yaml:2:8: not valid YAML: the character U\+{ord(sign):04X} isn't"
    ) as e:
        loads(f"grip: 1\nname: a{sign}b\nroot: {{node: a/b}}\n", "t.yaml")
    assert (e.value.line, e.value.column) == (2, 8)


def test_without_libyaml_everything_is_read_all_the_same(monkeypatch):
    text = "grip: 1\nname: a\nroot: {node: a/b}\nx-a:\n- b\n"
    expected = loads(text)
    monkeypatch.setattr(tree, "_Parser", yaml.SafeLoader)
    assert loads(text) == expected
    with pytest.raises(DocumentError, match="anchors"):
        loads(text + "doc: &a b\n")
    with pytest.raises(DocumentError, match="not valid YAML"):
        loads(text + 'doc: "\\UFFFFFFFF"\n')
