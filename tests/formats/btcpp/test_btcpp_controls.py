"""Control nodes: ticked, they show what BT.CPP 4 shows; the traces were derived from its documentation by hand."""

from __future__ import annotations

from typing import Any

import pytest
from btcpp_world import World, imported

ABC = "<A/><B/><C/>"
COUNTED = "<Condition ID='Ok'/>"

CASES: list[tuple[str, str, dict[str, str], list[str]]] = [
    # a Sequence goes on where it was, and begins anew after a failure
    ("Sequence", f"<Sequence>{ABC}</Sequence>", {"B": ".s"}, ["A B RUNNING", "B C SUCCESS"]),
    ("Sequence fails", f"<Sequence>{ABC}</Sequence>", {"B": "f s"}, ["A B FAILURE", "A B C SUCCESS"]),
    ("Fallback", f"<Fallback>{ABC}</Fallback>", {"A": "f", "B": ".f", "C": "s"}, ["A B RUNNING", "B C SUCCESS"]),
    ("Fallback fails", f"<Fallback>{ABC}</Fallback>", {"A": "f", "B": "f", "C": "f"}, ["A B C FAILURE"]),
    (
        "ReactiveSequence asks from the first child and halts what ran",
        f"<ReactiveSequence>{ABC}</ReactiveSequence>",
        {"A": "s s f s", "B": "..s", "C": "s"},
        ["A B RUNNING", "A B RUNNING", "A halt B FAILURE", "A B RUNNING"],
    ),
    (
        "ReactiveFallback",
        f"<ReactiveFallback>{ABC}</ReactiveFallback>",
        {"A": "f s", "B": "....s"},
        ["A B RUNNING", "A halt B SUCCESS"],
    ),
    (
        "AsyncSequence gives a tick after each child",
        f"<AsyncSequence>{ABC}</AsyncSequence>",
        {},
        ["A RUNNING", "B RUNNING", "C SUCCESS"],
    ),
    (
        "AsyncFallback gives a tick after each child",
        f"<AsyncFallback>{ABC}</AsyncFallback>",
        {"A": "f", "B": "f", "C": "f"},
        ["A RUNNING", "B RUNNING", "C FAILURE"],
    ),
    (
        "SequenceWithMemory resumes at the child that failed",
        f"<SequenceWithMemory>{ABC}</SequenceWithMemory>",
        {"B": "f s", "C": "f s"},
        ["A RUNNING", "B FAILURE", "B RUNNING", "C FAILURE"],
    ),
    (
        "SequenceWithMemory keeps its place when it is halted",
        f"<ReactiveSequence><Ok/><SequenceWithMemory>{ABC}</SequenceWithMemory></ReactiveSequence>",
        {"Ok": "s f s", "B": "..s .s"},
        ["Ok A RUNNING", "Ok FAILURE", "Ok B RUNNING"],
    ),
    (
        "Parallel ends with the first failure, and doesn't tick the rest",
        f"<Parallel>{ABC}</Parallel>",
        {"A": "..s", "B": "f"},
        ["A B halt A FAILURE"],
    ),
    (
        "Parallel counts successes and doesn't tick who has ended",
        f"<Parallel success_count='2' failure_count='2'>{ABC}</Parallel>",
        {"A": "f", "B": ".s", "C": "..s"},
        ["A B C RUNNING", "B C RUNNING", "C SUCCESS"],
    ),
    (
        "Parallel fails when it can't succeed any more",
        f"<Parallel success_count='2' failure_count='3'>{ABC}</Parallel>",
        {"A": "f", "B": ".f", "C": "....s"},
        ["A B C RUNNING", "B halt C FAILURE"],
    ),
    (
        "ParallelAll waits for all",
        f"<ParallelAll max_failures='2'>{ABC}</ParallelAll>",
        {"A": "f", "B": ".s", "C": "..s"},
        ["A B C RUNNING", "B C RUNNING", "C SUCCESS"],
    ),
    (
        "ParallelAll fails after all",
        f"<ParallelAll>{ABC}</ParallelAll>",
        {"A": "f", "B": ".s"},
        ["A B C RUNNING", "B FAILURE"],
    ),
    ("IfThenElse then", f"<IfThenElse>{ABC}</IfThenElse>", {"B": ".f"}, ["A B RUNNING", "B FAILURE"]),
    (
        "IfThenElse else",
        f"<IfThenElse>{ABC}</IfThenElse>",
        {"A": ".f", "C": ".s"},
        ["A RUNNING", "A C RUNNING", "C SUCCESS"],
    ),
    ("IfThenElse without else", "<IfThenElse><A/><B/></IfThenElse>", {"A": "f"}, ["A FAILURE"]),
    (
        "WhileDoElse asks on every tick, and halts one before the other begins",
        f"<WhileDoElse>{ABC}</WhileDoElse>",
        {"A": "s s f s", "B": ".....s", "C": "....s"},
        ["A B RUNNING", "A B RUNNING", "A halt B C RUNNING", "A halt C B RUNNING"],
    ),
    ("WhileDoElse ends", f"<WhileDoElse>{ABC}</WhileDoElse>", {"A": "f", "C": "f"}, ["A C FAILURE"]),
    (
        "WhileDoElse without else",
        "<WhileDoElse><A/><B/></WhileDoElse>",
        {"A": "s f", "B": "...s"},
        ["A B RUNNING", "A halt B FAILURE"],
    ),
    ("TryCatch succeeds", f"<TryCatch>{ABC}</TryCatch>", {}, ["A B SUCCESS"]),
    (
        "TryCatch catches",
        f"<TryCatch>{ABC}</TryCatch>",
        {"B": ".f", "C": ".s"},
        ["A B RUNNING", "B C RUNNING", "C FAILURE"],
    ),
    ("Inverter", "<Inverter><A/></Inverter>", {"A": ".s f"}, ["A RUNNING", "A FAILURE", "A SUCCESS"]),
    ("ForceSuccess", "<ForceSuccess><A/></ForceSuccess>", {"A": ".f"}, ["A RUNNING", "A SUCCESS"]),
    ("ForceFailure", "<ForceFailure><A/></ForceFailure>", {"A": "s"}, ["A FAILURE"]),
    ("Repeat", "<Repeat num_cycles='2'><A/></Repeat>", {}, ["A RUNNING", "A SUCCESS"]),
    ("Repeat stops", "<Repeat num_cycles='-1'><A/></Repeat>", {"A": "s s f"}, ["A RUNNING", "A RUNNING", "A FAILURE"]),
    (
        "RetryUntilSuccessful",
        "<RetryUntilSuccessful num_attempts='3'><A/></RetryUntilSuccessful>",
        {"A": "f f f s"},
        ["A RUNNING", "A RUNNING", "A FAILURE", "A SUCCESS"],
    ),
    (
        "RetryUntilSuccessful for ever",
        "<RetryUntilSuccessful num_attempts='-1'><A/></RetryUntilSuccessful>",
        {"A": "f f s"},
        ["A RUNNING", "A RUNNING", "A SUCCESS"],
    ),
    (
        "KeepRunningUntilFailure",
        "<KeepRunningUntilFailure><A/></KeepRunningUntilFailure>",
        {"A": "s f"},
        ["A RUNNING", "A FAILURE"],
    ),
    ("RunOnce", "<Sequence><RunOnce><A/></RunOnce><B/></Sequence>", {}, ["A B SUCCESS", "B SUCCESS"]),
    (
        "RunOnce keeps its status",
        "<RunOnce then_skip='false'><A/></RunOnce>",
        {"A": "f s"},
        ["A FAILURE", "FAILURE", "FAILURE"],
    ),
    ("RunOnce alone is skipped", "<RunOnce><A/></RunOnce>", {"A": ".s"}, ["A RUNNING", "A SUCCESS", "SKIPPED"]),
    ("Precondition", "<Precondition if='1 &lt; 0' else='SUCCESS'><A/></Precondition>", {}, ["SUCCESS"]),
    (
        "Precondition skips",
        "<Fallback><Precondition if='false' else='SKIPPED'><A/></Precondition><B/></Fallback>",
        {},
        ["B SUCCESS"],
    ),
    ("AlwaysSuccess, AlwaysFailure", "<Sequence><AlwaysSuccess/><AlwaysFailure/><A/></Sequence>", {}, ["FAILURE"]),
    (
        "a loop over a literal queue",
        "<LoopInt queue='3;5' value='{v}'><A v='{v}'/></LoopInt>",
        {},
        ["A RUNNING", "A RUNNING", "SUCCESS"],
    ),
    (
        "an empty queue",
        "<Fallback><LoopString queue='' value='{v}' if_empty='FAILURE'><A/></LoopString><B/></Fallback>",
        {},
        ["B SUCCESS"],
    ),
]


@pytest.mark.parametrize(("body", "scripts", "expected"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_a_node_shows_the_trace_of_bt_cpp(body: str, scripts: dict[str, str], expected: list[str]) -> None:
    assert World(body, scripts).ticks(len(expected)) == expected


SKIPS: list[tuple[str, str, dict[str, str], list[str]]] = [
    ("in a Sequence it is passed over", "<Sequence><A _skipIf='true'/><B/></Sequence>", {}, ["B SUCCESS"]),
    ("in a Fallback it is passed over", "<Fallback><A _skipIf='true'/><B/></Fallback>", {"B": "f"}, ["B FAILURE"]),
    ("a Sequence of skipped nodes is skipped", "<Sequence><A _skipIf='true'/></Sequence>", {}, ["SKIPPED"]),
    (
        "a Sequence of several skipped nodes is skipped",
        "<Fallback><Sequence><A _skipIf='true'/><B _skipIf='true'/></Sequence><C/></Fallback>",
        {"C": "f"},
        ["C FAILURE"],
    ),
    (
        "a Sequence that ran one of them is not",
        "<Fallback><Sequence><A _skipIf='true'/><B _skipIf='false'/></Sequence><C/></Fallback>",
        {"C": "f"},
        ["B SUCCESS"],
    ),
    (
        "a Fallback of several skipped nodes is skipped",
        "<Sequence><Fallback><A _skipIf='true'/><B _skipIf='1 == 1'/></Fallback><C/></Sequence>",
        {},
        ["C SUCCESS"],
    ),
    (
        "a Fallback of which one failed fails",
        "<Sequence><Fallback><A _skipIf='true'/><B _skipIf='false'/></Fallback><C/></Sequence>",
        {"B": "f"},
        ["B FAILURE"],
    ),
    ("an Inverter hands it up", "<Sequence><Inverter><A _skipIf='true'/></Inverter><B/></Sequence>", {}, ["B SUCCESS"]),
    (
        "a ForceFailure hands it up",
        "<Sequence><ForceFailure><A _skipIf='true'/></ForceFailure><B/></Sequence>",
        {},
        ["B SUCCESS"],
    ),
    (
        "branches of IfThenElse hand it up",
        "<Fallback><IfThenElse><A/><B _skipIf='true'/><C/></IfThenElse><D/></Fallback>",
        {},
        ["A D SUCCESS"],
    ),
    ("failureIf", "<A _failureIf='true' _successIf='true'/>", {}, ["FAILURE"]),
    ("successIf", "<A _successIf='true' _skipIf='true'/>", {}, ["SUCCESS"]),
]


@pytest.mark.parametrize(("body", "scripts", "expected"), [case[1:] for case in SKIPS], ids=[case[0] for case in SKIPS])
def test_what_is_skipped(body: str, scripts: dict[str, str], expected: list[str]) -> None:
    assert World(body, scripts).ticks(len(expected)) == expected


def test_while_halts_a_running_node_and_skips_it() -> None:
    writer = "<Action ID='W'><output_port name='go' type='bool'/></Action>"
    body = "<Sequence><Script code='go := true'/><Parallel><Repeat num_cycles='3'><W go='{go}'/></Repeat>"
    body += "<Sequence><A _while='go'/><B/></Sequence></Parallel></Sequence>"
    world = World(body, {"W": "go=True,s go=False,s .....s", "A": "....s"}, models=writer)
    assert world.ticks(2) == ["W A RUNNING", "W halt A B RUNNING"]


def test_a_switch_looks_at_its_variable_on_every_tick() -> None:
    writer = "<Action ID='W'><output_port name='to' type='std::string'/></Action>"
    body = "<Parallel success_count='2'><Repeat num_cycles='3'><W to='{way}'/></Repeat>"
    body += "<Switch2 variable='{way}' case_1='one' case_2='2'><A/><B/><C/></Switch2></Parallel>"
    world = World(body, {"W": "to='one',s to='2',s to='other',s", "A": "..s", "B": "..s", "C": ".s"}, models=writer)
    assert world.ticks(3) == ["W A RUNNING", "W halt A B RUNNING", "W halt B C RUNNING"]


def test_times_are_those_of_the_clock() -> None:
    world = World("<Timeout msec='1500'><A/></Timeout>", {"A": ".........s"})
    assert world.ticks(1) == ["A RUNNING"]
    world.clock.advance(1.6)
    assert world.ticks(1) == ["halt A FAILURE"]
    # Ticked every 20 ms; BT.CPP halts what runs after 50 ms, and nothing begins after that.
    world = World("<Timeout msec='50'><Sequence><A/><B/><C/></Sequence></Timeout>", {"A": "..s"})
    for expected in ("A RUNNING", "A RUNNING", "A B C SUCCESS"):
        assert world.ticks(1) == [expected]
        world.clock.advance(0.02)
    world = World("<Timeout msec='50'><Sequence><A/><B/><C/></Sequence></Timeout>", {"A": "...s"})
    for expected in ("A RUNNING", "A RUNNING", "A RUNNING", "halt A FAILURE"):
        assert world.ticks(1) == [expected]
        world.clock.advance(0.02)
    world = World("<Delay delay_msec='500'><A/></Delay>")
    assert world.ticks(1) == ["RUNNING"]
    world.clock.advance(0.5)
    assert world.ticks(1) == ["A SUCCESS"]
    assert World("<Timeout msec='0'><A/></Timeout>").ticks(1) == ["A SUCCESS"]


def test_scripts_after_a_node_run_by_how_it_ended() -> None:
    body = "<Sequence><Script code='n := 0; m := 0'/><ForceSuccess><A _onSuccess='n += 1' _onFailure='n += 10'"
    body += " _post='m += 1'/></ForceSuccess><B/></Sequence>"
    for end, told in (("s", (1, 1)), ("f", (10, 1))):
        world = World(body, {"A": end})
        world.tick()
        assert (world.value("n"), world.value("m")) == told


def test_sub_trees_have_blackboards_of_their_own_and_see_what_they_are_given() -> None:
    models = "<Action ID='Say'><input_port name='text'/><input_port name='n' type='int'/></Action>"
    body = "<Sequence><Script code=\"word := 'out'; shared := 'both'\"/><SubTree ID='S' a='{word}' n='3'/>"
    body += "<SubTree ID='T' _autoremap='true'/><Say text='{word}' n='1'/></Sequence>"
    sub = "<BehaviorTree ID='S'><Sequence><Script code=\"word := 'in'\"/><Say text='{a}' n='{n}'/>"
    sub += "<Say text='{@shared}' n='2'/><Say text='{word}' n='4'/></Sequence></BehaviorTree>"
    auto = "<BehaviorTree ID='T'><Say text='{shared}' n='5'/></BehaviorTree>"
    world = World(body, {}, sub, auto, models=models)
    assert world.ticks(1)[0].endswith("SUCCESS")
    seen = [(read["text"], read["n"]) for read in world.read]
    assert seen == [("out", 3), ("both", 2), ("in", 4), ("both", 5), ("out", 1)]


VALUES: list[tuple[str, Any]] = [
    ("x := 3", 3),
    ("x := 0x1F", 31),
    ("x := -2.5", -2.5),
    ("x := 'red'", "red"),
    ("x := true", True),
    ("x := 1; x += 2; x *= 3", 9),
    ("y := 7; x := y / 2", 3.5),
    ("y := 2; x := (y + 1) * 4 - 2", 10),
    ("y := 2; x := y > 1 ? 'many' : 'few'", "many"),
    ("y := 1; x := y > 1 ? 'many' : 'few'", "few"),
    ("a := true; b := false; x := a || b && b", False),  # && and || bind equally, to the left
    ("a := 1; x := !a", False),
    ("y := 1; x := 0 < y < 3", True),
    ("y := 0.1; x := y + 0.2 == 0.3", True),  # within a single float's epsilon
    ("y := 0.1; x := y + 0.2 != 0.3", False),
    ("c := 'b'; x := c == 'b' && 'a' < c", True),
    ("x := 'a' + 'b'", "ab"),
    ("y := 3; x := y; y = 4", 3),
]


@pytest.mark.parametrize(("code", "value"), VALUES, ids=[code for code, _ in VALUES])
def test_a_script_comes_to_what_it_comes_to_in_bt_cpp(code: str, value: Any) -> None:
    escaped = code.replace("&", "&amp;").replace("<", "&lt;")
    world = World(f'<Sequence><Script code="{escaped}"/><A v="{{x}}"/></Sequence>')
    assert world.ticks(1) == ["A SUCCESS"]
    assert world.value("x") == value
    assert type(world.value("x")) is type(value)


def test_set_blackboard_sets_by_the_type_of_the_port_that_reads() -> None:
    models = "<Action ID='A'><input_port name='n' type='int'/></Action>"
    world = World("<Sequence><SetBlackboard value='7' output_key='n'/><A n='{=}'/></Sequence>", models=models)
    assert world.ticks(1) == ["A SUCCESS"]
    assert world.read == [{"n": 7}]
    world = World(
        "<Sequence><SetBlackboard value='7' output_key='n'/><SetBlackboard value='{n}' output_key='m'/></Sequence>"
    )
    world.tick()


def test_a_port_is_taken_as_both_only_where_no_model_says_what_it_is() -> None:
    model = "<Action ID='A'><input_port name='p' type='int'/></Action>"
    said = [str(issue) for issue in imported("<A p='{x}'/>", models=model).issues]
    assert not any("treated as input and output" in text for text in said)
    said = [str(issue) for issue in imported("<A p='{x}'/>").issues]
    assert sum("'p'" in text and "treated as input and output" in text for text in said) == 1


def test_an_import_says_where_a_condition_may_be_asked_once_more() -> None:
    body = "<ReactiveSequence><A/>\n<SubTree ID='T'/></ReactiveSequence>"
    tree = "<BehaviorTree ID='T'><RetryUntilSuccessful num_attempts='3'><B/></RetryUntilSuccessful></BehaviorTree>"
    said = [issue for issue in imported(body, tree).issues if "asked once more" in issue.message]
    assert [(issue.path, issue.line) for issue in said] == [("<ReactiveSequence>", 1)]
    assert said[0].message.startswith("<RetryUntilSuccessful> is below")
