"""Forty files of all sorts: what is in them is imported whole, or every part that isn't is named with its line."""

from __future__ import annotations

from pathlib import Path

import pytest
from btcpp_world import BUILTIN, document, imported
from work import calls_in

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.compilers import to_tree
from grip_bt.compilers.binding import implementation_of
from grip_bt.formats.btcpp import from_xml
from grip_bt.formats.imported import ImportRefusedError
from grip_bt.nodes.flow import Succeed
from grip_bt.task import dumps, loads
from grip_bt.task.validation import validate

FOLDER = Path(__file__).parent / "wild"
FILES = sorted(FOLDER.glob("*.xml"))


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.stem)
def test_a_file_becomes_a_task_that_loads_passes_the_checks_and_compiles(file: Path) -> None:
    made = from_xml(file.read_text(encoding="utf-8"), BUILTIN, file.name, FOLDER)
    catalog = BUILTIN.with_manifests(made.manifests)
    assert not validate(made.task, catalog).errors
    assert loads(dumps(made.task)) == made.task

    def leaf(path, node, manifest):  # type: ignore[no-untyped-def]
        own = manifest.id.startswith("btcpp/")
        return Succeed(path, path, manifest, dict(node.with_), {}) if own else implementation_of(path, node, manifest)

    assert to_tree(made.task, catalog, leaf_factory=leaf).root is not None


PARTS: list[tuple[str, str]] = [
    ("<SubTreePlus ID='x'/>", "_autoremap"),
    ("<SubTree ID='Mian'/>", "there is no tree 'Mian'; did you mean 'Main'?"),
    ("<SubTree ID='Main'/>", "the tree 'Main' contains itself (Main > Main)"),
    ("<Sequence/>", "has 0 children and needs at least 1"),
    ("<Inverter><A/><B/></Inverter>", "has 2 children and needs 1"),
    ("<IfThenElse><A/></IfThenElse>", "has 1 children and needs 2 to 3"),
    (f"<IfThenElse>{4 * '<A/>'}</IfThenElse>", "has 4 children and needs 2 to 3"),
    ("<WhileDoElse><A/></WhileDoElse>", "has 1 children and needs 2 to 3"),
    (f"<WhileDoElse>{4 * '<A/>'}</WhileDoElse>", "has 4 children and needs 2 to 3"),
    ("<Repeat num_cycles='many'><A/></Repeat>", "`num_cycles` is 'many' and has to be a whole number"),
    ("<Repeat num_cycles='0'><A/></Repeat>", "write 1 or more, or -1 for ever"),
    ("<RetryUntilSuccessful num_attempts='0'><A/></RetryUntilSuccessful>", "write 1 or more, or -1 for ever"),
    ("<Repeat><A/></Repeat>", "needs `num_cycles`"),
    ("<Repeat num_cycle='2'><A/></Repeat>", "has no port 'num_cycle'; did you mean 'num_cycles'?"),
    ("<Timeout msec='-1'><A/></Timeout>", "can't be less than 0"),
    ("<Switch2 variable='x' case_1='1' case_2='2'><A/><B/><C/></Switch2>", "`variable` has to be a key in braces"),
    ("<Switch2 variable='{x}' case_1='1' case_2='1'><A/><B/><C/></Switch2>", "`case_2` is '1' again"),
    ("<LoopInt queue='1;two' value='{x}'><A/></LoopInt>", "invalid literal for int()"),
    ("<LoopInt queue='1' value='x'><A/></LoopInt>", "`value` has to be a key in braces"),
    ("<LoopInt queue='1' value='{x}' if_empty='RUNNING'><A/></LoopInt>", "the status 'RUNNING' isn't SUCCESS"),
    ("<SetBlackboard value='1'/>", "needs `output_key`"),
    ("<Script code='x := '/>", "it ends where a value is missing"),
    ("<Script code='x := 3 4'/>", "';' is missing before '4'"),
    ("<Script code='x := #'/>", "isn't a word of the language"),
    ("<Script code='3 := 4'/>", "left of ':=' stands something that isn't a blackboard entry"),
    ("<Script code='x := a + b + c + d + e + f + g + h + i'/>", "more than 8 variables in one script"),
]


@pytest.mark.parametrize(("body", "message"), PARTS, ids=[body for body, _ in PARTS])
def test_a_part_without_an_equal_is_refused_by_name(body: str, message: str) -> None:
    with pytest.raises(ImportRefusedError) as refused:
        from_xml(document(body), BUILTIN, "f.xml")
    assert message in str(refused.value)
    assert "f.xml:1: error[no-equivalent] <" in str(refused.value)


BY_ITS_RULES = [
    "<ManualSelector><A/></ManualSelector>",
    "<UnsetBlackboard key='x'/>",
    "<SkipUnlessUpdated entry='{x}'><A/></SkipUnlessUpdated>",
    "<WaitValueUpdate entry='{x}'><A/></WaitValueUpdate>",
    "<ConsumeQueue><A/></ConsumeQueue>",
    "<SequenceStar><A/></SequenceStar>",
    "<A _onHalted='x := 1'/>",
    "<Mine><A/></Mine>",
    "<Parallel success_count='4'><A/><B/></Parallel>",
    "<Parallel><A _skipIf='true'/><B/></Parallel>",
    "<ParallelAll><A _while='true'/><B/></ParallelAll>",
    "<Repeat num_cycles='2'><A _skipIf='true'/></Repeat>",
    "<Repeat num_cycles='{n}'><A/></Repeat>",
    "<Timeout msec='9'><A _skipIf='true'/></Timeout>",
    "<TryCatch catch_on_halt='true'><A/><B/></TryCatch>",
    "<TryCatch><A _skipIf='true'/><B/></TryCatch>",
    "<AsyncSequence><A _skipIf='true'/></AsyncSequence>",
    "<SequenceWithMemory><A _skipIf='true'/></SequenceWithMemory>",
    "<IfThenElse><A _skipIf='true'/><B/></IfThenElse>",
    "<WhileDoElse><A _skipIf='true'/><B/></WhileDoElse>",
    "<Sequence><Script code='x := 1'/><Switch2 variable='{x}' case_1='1' case_2='B'><A/><B/><C/></Switch2></Sequence>",
    "<Precondition if='true' else='RUNNING'><A/></Precondition>",
    "<Script code='x := 1 &amp; 2'/>",
    "<Script code='x := ~3'/>",
    "<Script code=\"w := 'a'; x := w .. 'b'\"/>",
    "<Script code='x'/>",
    "<Script code='x := (y := 2)'/>",
    "<Script code='x := 2 + (1 > 0 ? 3 : 4)'/>",
    "<Script code='y := true; x := y + 1'/>",
    "<Script code=\"y := 'a'; x := y == 1\"/>",
    "<Script code='x := 1 / 0'/>",
    "<Script code='x := 1 + 99999999999999999'/>",
    "<ScriptCondition code='a; b'/>",
    "<ScriptCondition code=\"'text'\"/>",
]
"""What no kind is equal to, and a control node or a script of BehaviorTree.CPP's own is."""


@pytest.mark.parametrize("body", BY_ITS_RULES)
def test_what_no_kind_is_equal_to_is_imported_all_the_same(body: str) -> None:
    made = imported(body)
    assert loads(dumps(made.task)) == made.task


def test_all_refusals_of_a_file_are_listed_in_their_order() -> None:
    body = "<Sequence>\n<SubTreePlus ID='a'/>\n<Fallback>\n<Inverter/>\n</Fallback>\n"
    body += "<Script code='?'/>\n</Sequence>"
    with pytest.raises(ImportRefusedError) as refused:
        from_xml(document(body), BUILTIN, "f.xml")
    assert [issue.line for issue in refused.value.issues] == [2, 4, 6]
    assert str(refused.value).startswith("f.xml can't be converted to a task: 3 parts have no exact equivalent:")


HOSTILE: list[tuple[str, str, str]] = [
    ("no XML", "{", "isn't well-formed XML"),
    ("empty", "", "isn't well-formed XML"),
    ("unclosed", "<root BTCPP_format='4'><BehaviorTree ID='A'>", "isn't well-formed XML"),
    ("bomb", '<!DOCTYPE r [<!ENTITY a "aa"><!ENTITY b "&a;&a;">]><root>&b;</root>', "it declares an entity"),
    ("file", '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]><root>&a;</root>', "it declares an entity"),
    ("deep", "<root>" + "<Sequence>" * 10_000, "nested more than 120 deep"),
    ("huge", "<root>" + "<!-- x -->" * 500_000, "larger than"),
    ("other", "<robot/>", 'a file of BehaviorTree.CPP begins with <root BTCPP_format="4">'),
    ("version 3", "<root BTCPP_format='3'/>", "convert_v3_to_v4.py makes one"),
    ("no tree", "<root BTCPP_format='4'/>", "there is no <BehaviorTree>"),
    (
        "several",
        "<root BTCPP_format='4'><BehaviorTree ID='A'/><BehaviorTree ID='B'/></root>",
        "no `main_tree_to_execute`",
    ),
    ("twice", "<root BTCPP_format='4'><BehaviorTree ID='A'/><BehaviorTree ID='A'/></root>", "needs an `ID` of its own"),
    (
        "lost",
        "<root BTCPP_format='4' main_tree_to_execute='B'><BehaviorTree ID='A'/></root>",
        "no <BehaviorTree ID='B'>",
    ),
    ("stray", "<root BTCPP_format='4'><Sequence/></root>", "there is no <BehaviorTree>"),
    (
        "package",
        "<root BTCPP_format='4'><include ros_pkg='p' path='a.xml'/></root>",
        "there is no package 'p' in the workspace",
    ),
    ("outside", "<root BTCPP_format='4'><include path='../../pyproject.toml'/></root>", "there is no file"),
    ("absolute", "<root BTCPP_format='4'><include path='/etc/passwd'/></root>", "there is no file"),
    ("empty tree", "<root BTCPP_format='4'><BehaviorTree ID='A'/></root>", "has 0 children and needs 1"),
    ("long script", document(f"<Script code='{'a' * 5000}'/>"), "longer than 4000 characters"),
    ("deep script", document(f"<Script code='x := {'(' * 3000}1{')' * 3000}'/>"), "longer than 4000 characters"),
    ("nested script", document(f"<Script code='x := {'(' * 900}1{')' * 900}'/>"), "nested deeper than 40 levels"),
]


def test_sub_trees_of_sub_trees_are_bounded() -> None:
    inside = [f"<SubTree ID='T{n + 1}'/>" * 10 for n in range(9)]
    trees = [f"<BehaviorTree ID='T{n}'><Sequence>{body}</Sequence></BehaviorTree>" for n, body in enumerate(inside)]
    text = document("<SubTree ID='T0'/>", *trees, "<BehaviorTree ID='T9'><A/></BehaviorTree>")

    def read() -> None:
        with pytest.raises(DocumentError, match="more than 20000 nodes"):
            from_xml(text, BUILTIN, "f.xml")

    assert calls_in(read) < 10_000_000


@pytest.mark.parametrize(("text", "message"), [case[1:] for case in HOSTILE], ids=[case[0] for case in HOSTILE])
def test_a_hostile_file_is_refused_with_little_work(text: str, message: str) -> None:
    def read() -> None:
        with pytest.raises(GripError) as error:
            from_xml(text, BUILTIN, "f.xml", FOLDER)
        assert message in str(error.value)

    assert calls_in(read) < 100_000


def test_included_files_may_include_each_other_and_lie_in_the_project() -> None:
    text = "<root BTCPP_format='4' main_tree_to_execute='CloseGently'><include path='hand.xml'/></root>"
    made = from_xml(text, BUILTIN, "f.xml", FOLDER / "parts", FOLDER)
    assert made.task.name == "CloseGently"
    up = "<root BTCPP_format='4' main_tree_to_execute='CloseGently'><include path='../parts/hand.xml'/></root>"
    assert from_xml(up, BUILTIN, "f.xml", FOLDER / "parts", FOLDER).task == made.task


def test_a_tree_other_than_the_main_one_can_be_chosen() -> None:
    text = (FOLDER / "16_sub_tree_ports.xml").read_text(encoding="utf-8")
    assert from_xml(text, BUILTIN, "f.xml", FOLDER, tree="PickAndPlace").task.name == "PickAndPlace"
    with pytest.raises(DocumentError, match="did you mean 'Main'"):
        from_xml(text, BUILTIN, "f.xml", FOLDER, tree="Mian")
