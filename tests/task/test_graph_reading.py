"""The quick way into a text and the patient way agree, wherever the quick one answers at all."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_tasks import tasks
from random_texts import with_comments
from work import calls_in

from grip_bt.base.errors import DocumentError
from grip_bt.base.yaml.syntax import _patiently, _quickly, is_usual, plain
from grip_bt.task import catalog, dumps, loads
from grip_bt.task.quick import _by_libyaml, _Meanings, quick_data
from grip_bt.task.tidy import tidy_data

bits = st.lists(
    st.sampled_from(
        ["a: ", "b:", "c: d", "\n", "\n  ", "\n    ", "\n\n", "\n\n\n", "- ", "  ", "|", "|-", "|+", ">", ">-", "text",
         "# c", "  # c", "\n# c", "{a: 1}", "{a: ,b}", "[1, 2]", "''", '"q"', '"\\u00e9"', "é", "!", "&", "*", "%", "@",
         "`", "?", "? ", ",", "]", "}", "[", "{", "'", '"', "\t", "\\", "1e5", "0x1F", "~", "on", "\r\n", "\r", "\x85",
         "\ufeff", "\u2028", "--- ", "...", "<<: "]
    ),
    max_size=14,
).map("".join)  # fmt: skip


@settings(deadline=None, max_examples=250)
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


@settings(deadline=None, max_examples=250)
@given(bits, st.sampled_from(["{}", "- {}", "- a: {}\n  b: 1\n- c", "[a, {}]", "- - {}\n- b: {}\n"]))
def test_lists_are_read_alike_too_where_they_are_expected(bit, around):
    text = around.replace("{}", bit)
    placed = _quickly(text, lists=True) if is_usual(text) else None
    if placed is not None:
        assert repr(placed) == repr(_patiently(text, ""))


def test_built_in_manifests_are_read_by_libyaml():
    files = sorted((Path(catalog.__file__).parent / "builtin").glob("*.yaml"))
    assert len(files) > 5
    for file in files:
        assert _quickly(file.read_text(), file.name, lists=True) is not None, file


keys = st.sampled_from(
    ["a", "b", "c", "x-a", "a b", "no", "null", "true", "1", "a.b", "kind", "'q'", "é", "a/b", "- a"]
)
values = st.sampled_from(
    ["", " 1", " text", " some text ", "  two", " a#b", " a #b", " a: b", " a:b", " a:", " a::b", " -1", " -a", " - a",
     " ~", " null", " .5", " ...", " 1_0", " 0x1F", " +1", " list[a]", " a, b", " {a: 1}", " {a: 1, b: text of words}",
     " {a: 1, a: 2}", " {a: 1,b: 2}", " {a:1}", " {a: b:c}", " {a: {b: [1, x]}, c: 'q'}", " { a: b }", " {null: 1}",
     " {a: b }", " {}", " []", " [ ]", " [a, b]", " [a, [b, {c: d}], ]", " [a: b]", " [a b, -1, -c]", ' "q"', ' "q" ',
     " 'it''s'", ' "q\\n"', ' "a" b', " 'a # b'", ' ["a, b", c]', " {a: b} c", " {a: 'b'} # c", " [a]#c", " |", " >",
     " |-", " >-", " |+", " | # c", " a\tb", " é", " {a: é}", " &a b", " *a", " !t b", " a &b", " @a", " `a", " =",
     " %a", " {a: ?}", " {? a: b}", " a ? b", ' {"a": 1}', " {a: 1e5, b: ~x}", " 99999999999999999999"]
)  # fmt: skip
lines = st.tuples(
    st.sampled_from(["", "", "", "  ", "  ", "    ", "   ", " "]),
    st.one_of(
        st.tuples(keys, st.just(":"), values, st.sampled_from(["", "", "", " # c", "   ", "# c"])).map("".join),
        st.sampled_from(["", "# c", "text", "other text ", "- a", "---", "...", "}", "\\", "a", "%A"]),
    ),
).map("".join)


@settings(deadline=None, max_examples=150)
@given(st.lists(lines, min_size=1, max_size=7).map("\n".join), st.sampled_from(["\n", "", "\n\n", "\n  \n", "\n#"]))
def test_what_is_read_as_tidy_is_what_the_patient_parser_reads(text, end):
    text += end
    if not is_usual(text):
        return
    try:
        tidy = tidy_data(text, _Meanings())
    except ValueError:
        tidy = None
    if tidy is not None:
        assert repr(tidy) == repr(plain(_patiently(text, "")))


@settings(deadline=None, max_examples=150)
@given(tasks, st.randoms())
def test_canonical_texts_are_read_alike_with_comments_strewn_in(task, random):
    text, _ = with_comments(dumps(task), random)
    if is_usual(text):
        tidy = tidy_data(text, _Meanings())
        assert tidy is None or repr(tidy) == repr(_by_libyaml(text))


@pytest.mark.parametrize(
    "text",
    ["a: b\n", "a:\n  b: 1\n\n  c:\n# d\n  e: {f: g}\nh: [1, 'x', {y: z}]\n", "a: >-\n  b\n  c\n\n  d\ne: f\n",
     "a: |\n  b: c\n    d\n\n  # e\n\nf: pkg.mod:Class\n", "a: list[Grasp]  # b\nc: reached < limit\n"],
)  # fmt: skip
def test_tidy_texts_need_no_library(text):
    assert repr(tidy_data(text, _Meanings())) == repr(plain(_patiently(text, "")))


@pytest.mark.parametrize(
    "sign", [" ", "a ", "a: ", "{a: b, ", "a: {a: b, ", "a: 'b", "a: x:", "a: [", "k: >\n  a ", "#", "\n"]
)
def test_no_text_keeps_the_tidy_reader_busy(sign):
    text = (sign * 200_000)[:200_000]
    for whole in (text, text + "\n", f"a:{text}?\n", f"a: |\n {text}"):
        assert calls_in(tidy_data, whole, _Meanings()) < len(whole)


def test_the_example_of_the_project_is_read_quickly():
    text = (Path(__file__).parents[2] / "examples" / "tasks" / "reactive_pick.yaml").read_text()
    assert quick_data(text) == plain(_patiently(text, ""))


@pytest.mark.parametrize("word", ["with_", "in_", "x"])
def test_a_fields_own_name_is_no_key_of_a_file(word):
    with pytest.raises(DocumentError, match=f"unknown key '{word}'"):
        loads(f"grip: 1\nname: a\nroot: {{node: a/b, {word}: {{a: b}}}}\n")


def test_without_libyaml_everything_is_read_all_the_same(monkeypatch):
    text = "grip: 1\nname: a\nroot: {node: a/b}\nx-a:\n- b\n"
    expected = loads(text)
    monkeypatch.setitem(__import__("sys").modules, "yaml.cyaml", None)
    assert quick_data(text) is None
    assert loads(text) == expected
    with pytest.raises(DocumentError, match="anchor"):
        loads(text + "doc: &a b\n")
