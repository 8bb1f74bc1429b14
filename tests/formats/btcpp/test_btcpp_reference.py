"""Random trees of BT.CPP: imported, they show what an independent reading of its rules shows, tick by tick."""

from __future__ import annotations

import os
import re

from btcpp_reference import Reference
from btcpp_world import World
from hypothesis import assume, given, settings
from hypothesis import strategies as st

LEAF = st.sampled_from("ABCDEF")
FREE = st.sampled_from(
    ["", "", "", "", " _skipIf='true'", " _skipIf='1 &lt; 0'", " _failureIf='true'", " _successIf='true'"]
)
LEAVES = st.builds(lambda tag, said: f"<{tag}{said}/>", LEAF, FREE)
BARE = LEAF.map(lambda tag: f"<{tag}/>")


def join(tag: str, children: list[str], said: str = "") -> str:
    return f"<{tag}{said}>{''.join(children)}</{tag}>"


def containers(below: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    series = ["Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback"]
    some = st.lists(below, min_size=1, max_size=4)
    kept = st.lists(BARE, min_size=1, max_size=3)
    return st.one_of(
        st.builds(join, st.sampled_from(series), some, FREE),
        st.builds(join, st.just("SequenceWithMemory"), kept),
        st.builds(
            lambda tag, child: join(tag, [child]), st.sampled_from(["Inverter", "ForceSuccess", "ForceFailure"]), below
        ),
        st.builds(lambda child: join("RunOnce", [child]), below),
        st.builds(lambda n, child: join("Repeat", [child], f" num_cycles='{n}'"), st.integers(1, 3), BARE),
        st.builds(
            lambda n, child: join("RetryUntilSuccessful", [child], f" num_attempts='{n}'"), st.integers(1, 3), BARE
        ),
        st.builds(lambda c, a, b: join("IfThenElse", [c, a, b]), BARE, below, below),
        st.builds(lambda c, a: join("IfThenElse", [c, a]), BARE, below),
        st.builds(lambda a, b: join("WhileDoElse", ["<Ask/>", a, b]), below, below),
        st.builds(lambda tried, caught: join("TryCatch", [*tried, caught]), kept, below),
        st.lists(
            st.one_of(BARE, st.lists(BARE, min_size=1, max_size=3).map(lambda c: join("Sequence", c))),
            min_size=1,
            max_size=4,
        ).flatmap(parallel),
    )


def parallel(children: list[str]) -> st.SearchStrategy[str]:
    count = st.integers(1, len(children))
    either = st.builds(
        lambda s, f: join("Parallel", children, f" success_count='{s}' failure_count='{f}'"), count, count
    )
    return either | count.map(lambda most: join("ParallelAll", children, f" max_failures='{most}'"))


BODIES = st.recursive(LEAVES, containers, max_leaves=10)
WORD = st.sampled_from(["s", "f", ".s", ".f", "..s", "....s"])
SCRIPTS = st.fixed_dictionaries(
    {tag: st.lists(WORD, min_size=1, max_size=5).map(" ".join) for tag in "ABCDEF"}
    | {"Ask": st.lists(st.sampled_from("sf"), min_size=1, max_size=8).map(" ".join)}
)


@settings(max_examples=int(os.environ.get("GRIP_FUZZ_TASKS", "80")), deadline=None)
@given(BODIES, SCRIPTS)
def test_an_imported_tree_shows_what_bt_cpp_shows(body: str, scripts: dict[str, str]) -> None:
    assume(len(re.findall("<[A-Z]", body)) <= 40)
    expected = Reference(body, scripts).ticks(8)
    assert World(body, scripts).ticks(8) == expected
    assert World(body, scripts, by_engine=True).ticks(8) == expected


def timed(below: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Return containers, many of them with a deadline; what may be skipped isn't inside of one."""
    limited = st.builds(
        lambda ms, child: join("Timeout", [child], f" msec='{ms}'"),
        st.sampled_from([500, 1000, 1500, 2000, 3500]),
        below,
    )
    series = st.sampled_from(["Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback"])
    some = st.lists(below, min_size=1, max_size=3)
    both = st.lists(below, min_size=2, max_size=2).map(
        lambda c: join("Parallel", c, " success_count='1' failure_count='1'")
    )
    turned = st.builds(lambda child: join("Inverter", [child]), below)
    return st.one_of(limited, limited, st.builds(join, series, some), both, turned)


def told(ticks: list[str]) -> list[tuple[list[str], list[str]]]:
    """Return of each tick who was ticked and how it ended; and who was halted, since BT.CPP's timer does so before."""
    halted = [re.findall("halt ([A-Z])", tick) for tick in ticks]
    return [(re.sub("halt [A-Z]", "", tick).split(), sorted(row)) for tick, row in zip(ticks, halted, strict=True)]


@settings(max_examples=int(os.environ.get("GRIP_FUZZ_TASKS", "60")), deadline=None)
@given(st.recursive(BARE, timed, max_leaves=8), SCRIPTS)
def test_imported_deadlines_are_those_of_bt_cpp(body: str, scripts: dict[str, str]) -> None:
    assume("Timeout" in body)
    expected = told(Reference(body, scripts).ticks(9, 1.0))
    assert told(World(body, scripts).ticks(9, 1.0)) == expected
    assert told(World(body, scripts, by_engine=True).ticks(9, 1.0)) == expected
