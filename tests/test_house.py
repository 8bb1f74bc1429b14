"""What holds of the sources as a whole: kinds are asked, not named; what others call has types that say something."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

import grip_bt
from grip_bt.task.model import KINDS

ROOT = Path(grip_bt.__file__).parent
OTHER_MEANINGS = {"force", "timeout"}
"""Kinds whose names are also those of parameters: a hand's force, a call's time-out."""
SMACH = ("smach_", "stand_ins")
"""Leaves around other people's states, of which nothing is known."""


def texts(tree: ast.AST) -> Iterator[str]:
    """Yield the texts of a module that are no documentation."""
    docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
            yield node.value


def test_a_kind_is_named_in_its_own_file_and_hardly_anywhere_else() -> None:
    files = [f for f in ROOT.glob("**/*.py") if not f.is_relative_to(ROOT / "formats") and f.parent.name != "kinds"]
    said = Counter(text for file in files for text in texts(ast.parse(file.read_text(encoding="utf-8"))))
    assert {kind: said[kind] for kind in KINDS.keys() - OTHER_MEANINGS if said[kind] > 3} == {}


def annotations(body: list[ast.stmt]) -> Iterator[tuple[str, ast.expr | None]]:
    """Yield the name and each annotation of what is public."""
    for item in body:
        if isinstance(item, ast.ClassDef) and not item.name.startswith("_"):
            yield from annotations(item.body)
        elif isinstance(item, ast.FunctionDef | ast.AsyncFunctionDef):
            if not item.name.startswith("_") or item.name == "__init__":
                arguments = (*item.args.posonlyargs, *item.args.args, *item.args.kwonlyargs)
                yield from ((item.name, each.annotation) for each in arguments)
                yield item.name, item.returns
        elif isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
            if not item.target.id.startswith("_"):
                yield item.target.id, item.annotation


@pytest.mark.parametrize("room", ["task", "nodes", "commanders"])
def test_no_public_face_takes_or_gives_just_anything(room: str) -> None:
    found = [
        f"{file.relative_to(ROOT)}: {name}"
        for file in (ROOT / room).glob("**/*.py")
        if not file.name.startswith(SMACH)
        for name, annotation in annotations(ast.parse(file.read_text(encoding="utf-8")).body)
        if annotation is not None and "Any" in {n.id for n in ast.walk(annotation) if isinstance(n, ast.Name)}
    ]
    assert found == []


def test_browser_tests_are_where_they_are_looked_for() -> None:
    tests = Path(__file__).parent
    assert "tests/gui\n" in (tests.parent / "tools" / "browser_tests.sh").read_text(encoding="utf-8")
    marked = [
        file.relative_to(tests).parts[0]
        for file in tests.rglob("*.py")
        if "mark" + ".e2e" in file.read_text(encoding="utf-8")
    ]
    assert set(marked) == {"gui"}
