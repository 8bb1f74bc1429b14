"""The figures of a campaign: against formulas by hand, and against SciPy."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from campaign_rows import by_hand, row
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.app.campaign.report import as_csv, as_text
from grip_bt.app.campaign.results import Results
from grip_bt.app.campaign.statistics import fisher, mcnemar, summary, wilson


@settings(deadline=None)
@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=60))
def test_rates_have_wilsons_interval_and_pairs_mcnemars_exact_test(pairs):
    head = {"name": "x", "variants": {"a": {}, "b": {}}}
    rows = [r for seed, (a, b) in enumerate(pairs) for r in (row("a", seed, a), row("b", seed, b))]
    said = summary(Results(Path("x"), head, rows))
    for index, name in enumerate("ab"):
        good = sum(pair[index] for pair in pairs)
        assert said["variants"][name]["successes"] == good
        assert said["variants"][name]["interval"] == pytest.approx(by_hand(good, len(pairs)), abs=1e-4)
    only_a, only_b = sum(a and not b for a, b in pairs), sum(b and not a for a, b in pairs)
    n, k = only_a + only_b, min(only_a, only_b)
    p = min(1.0, 2 * sum(math.comb(n, i) for i in range(k + 1)) / 2**n) if n else 1.0
    (found,) = said["compared"]["variant"]
    assert found["p"] == found["holm"] == pytest.approx(p, abs=1e-12)
    assert as_csv(Results(Path("x"), head, rows)).count("\n") == len(rows) + 1
    assert as_text(Results(Path("x"), head, rows)).startswith("# x")


def test_only_common_seeds_are_compared():
    head = {"name": "x", "variants": {"a": {}, "b": {}, "never_run": {}}}
    rows = [row("a", 1, True), row("a", 2, True), row("b", 2, False), row("b", 3, False)]
    said = summary(Results(Path("x"), head, rows))
    (found,) = said["compared"]["variant"]
    assert (found["pairs"], found["only_first"], found["only_second"], found["p"]) == (1, 1, 0, 1.0)
    assert list(said["variants"]) == ["a", "b"]


@pytest.mark.parametrize(
    ("good", "of", "other", "other_of"), [(3, 20, 12, 20), (0, 5, 5, 5), (7, 9, 4, 30), (2, 2, 2, 2)]
)
def test_exact_tests_are_those_of_scipy(good, of, other, other_of):
    stats = pytest.importorskip("scipy.stats")
    table = [[good, of - good], [other, other_of - other]]
    assert fisher(good, of, other, other_of) == pytest.approx(stats.fisher_exact(table).pvalue)
    assert mcnemar(good, other) == pytest.approx(stats.binomtest(good, good + other).pvalue)
    said = stats.binomtest(good, of).proportion_ci(method="wilson")
    assert wilson(good, of) == pytest.approx((said.low, said.high))


def test_p_is_corrected_for_the_number_of_pairs_by_holm():
    head = {"name": "x", "variants": {"a": {}, "b": {}, "c": {}}}
    rows = [row(name, seed, seed < good) for name, good in (("a", 12), ("b", 6), ("c", 0)) for seed in range(12)]
    found = summary(Results(Path("x"), head, rows))["compared"]["variant"]
    ordered = sorted(found, key=lambda pair: pair["p"])
    raw = [pair["p"] for pair in ordered]
    assert [pair["holm"] for pair in ordered] == pytest.approx([3 * raw[0], 2 * raw[1], max(2 * raw[1], raw[2])])
