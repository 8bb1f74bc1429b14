"""Both targets do what the oracle does, on random tasks and on every case that once showed a difference."""

from __future__ import annotations

import ast
import io
import os
import sys
from math import sqrt
from pathlib import Path
from typing import Any

import pytest
from parity_generate import make_case, outside_of
from parity_shrink import shrink
from parity_world import difference
from ruamel.yaml import YAML

from grip_bt.base.errors import InvalidTaskError

TASKS = int(os.environ.get("GRIP_FUZZ_TASKS", "1000"))
FIRST = int(os.environ.get("GRIP_FUZZ_SEED", "0"))
CHUNKS = 20
FOLDER = Path(__file__).parent / "cases"
CASES = sorted(FOLDER.glob("*.yaml"))


def differs(case: dict[str, Any]) -> bool:
    """Tell whether a valid case shows a difference."""
    try:
        return bool(difference(case))
    except (InvalidTaskError, ValueError, KeyError):
        return False


def report(seed: int, case: dict[str, Any], found: str) -> str:
    """Shrink a case to a file that this module runs from now on, and return what differs in it.

    What differed once and does no more hangs on threads; then what was found at first is all that there is.
    """
    small = shrink(case, differs)
    file = FOLDER / f"seed_{seed}.yaml"
    text = io.StringIO()
    YAML().dump(small, text)  # the safe one would sort the children
    file.write_text(text.getvalue())
    return f"seed {seed}, shrunk to {file}: {difference(small) or found}"


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_tree_plan_machine_and_oracle_agree_on_random_tasks(chunk: int) -> None:
    size = max(1, TASKS // CHUNKS)
    whole = 0
    for seed in range(FIRST + chunk * size, FIRST + (chunk + 1) * size):
        case = {**make_case(seed), "outside": outside_of(seed)}
        found = difference(case)
        if found:
            pytest.fail(report(seed, case, found))
        whole += found is None
    usual = 0.95 * size
    assert whole >= usual - 6 * sqrt(0.05 * usual) - 1, f"only {whole} of {size} tasks were compared to their end"


@pytest.mark.parametrize("file", CASES, ids=lambda f: f.stem)
def test_they_agree_on_cases_that_once_differed(file: Path) -> None:
    assert difference(YAML(typ="safe").load(file.read_text())) is None


def test_the_oracle_shares_no_code_with_what_it_judges() -> None:
    for file in (Path(__file__).parent / "oracle").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level:
                names.append(node.module or "")
            assert {name.split(".")[0] for name in names} <= sys.stdlib_module_names, file.name
