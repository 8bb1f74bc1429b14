"""The quick way into a text and the patient way agree, wherever the quick one answers at all."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.errors import DocumentError
from grip_bt.graph import loads
from grip_bt.graph.quick import quick_data
from grip_bt.graph.syntax import _patiently, _quickly, is_usual, plain

bits = st.lists(
    st.sampled_from(
        ["a: ", "b:", "c: d", "\n", "\n  ", "\n    ", "\n\n", "\n\n\n", "- ", "  ", "|", "|-", "|+", ">", ">-", "text",
         "# c", "  # c", "\n# c", "{a: 1}", "{a: ,b}", "[1, 2]", "''", '"q"', '"\\u00e9"', "é", "!", "&", "*", "%", "@",
         "`", "?", "? ", ",", "]", "}", "[", "{", "'", '"', "\t", "\\", "1e5", "0x1F", "~", "on", "\r\n", "\r", "\x85",
         "\ufeff", "\u2028", "--- ", "...", "<<: "]
    ),
    max_size=14,
).map("".join)  # fmt: skip


@settings(deadline=None, max_examples=1500)
@given(bits, st.sampled_from(["{}", "a: {}", "a:\n  {}\nb: 1", "a: {{b: {}}}", "a: |\n  {}", "a: >\n  {}\n b\n"]))
def test_libyaml_reads_what_it_reads_like_the_patient_parser_places_included(bit, around):
    text = around.format(bit)
    quick = quick_data(text)
    placed = _quickly(text) if is_usual(text) else None
    assert (quick is None) == (placed is None)
    if placed is not None:
        patient = _patiently(text, "")
        assert repr(placed) == repr(patient)
        assert repr(quick) == repr(plain(patient))


def test_the_example_of_the_project_is_read_quickly():
    text = (Path(__file__).parents[2] / "examples" / "tasks" / "reactive_pick.yaml").read_text()
    assert quick_data(text) == plain(_patiently(text, ""))


@pytest.mark.parametrize("word", ["with_", "in_", "x"])
def test_a_fields_own_name_is_no_key_of_a_file(word):
    with pytest.raises(DocumentError, match=f"unknown key '{word}'"):
        loads(f"grip: 1\nname: a\nroot: {{node: a/b, {word}: {{a: b}}}}\n")


def test_without_libyaml_everything_is_read_all_the_same(monkeypatch):
    text = "grip: 1\nname: a\nroot: {node: a/b}\n"
    expected = loads(text)
    monkeypatch.setitem(__import__("sys").modules, "yaml.cyaml", None)
    assert quick_data(text) is None
    assert loads(text) == expected
    with pytest.raises(DocumentError, match="anchor"):
        loads(text + "doc: &a b\n")
