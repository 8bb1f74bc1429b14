"""Fixes as commands: each one can be carried out, and the issue is gone."""

import pytest
from test_validation_rules import EXAMPLES, catalog  # noqa: F401  (a fixture)

from grip_bt.task import read_text
from grip_bt.task.edit import apply_to_document
from grip_bt.task.validation import validate
from grip_bt.task.validation.fixes import MOST, Fixer

FIXED = (
    "unknown-node", "unknown-parameter", "unknown-input", "unknown-output", "missing-input", "undeclared-variable",
    "wrong-variable-type", "never-read", "shadowed-variable", "unknown-outcome", "unknown-code", "unknown-target",
    "missing-target", "unknown-child", "impossible-outcome", "unreachable-node", "misplaced-on", "unused-outcome",
    "parallel-writes", "parallel-read-write", "unknown-message",
)  # fmt: skip


@pytest.mark.parametrize("code", FIXED)
def test_every_fix_removes_its_issue(code, catalog):  # noqa: F811
    document = read_text(EXAMPLES[code][0])
    issues = [i for i in validate(document.task, catalog, document).issues if i.code == code]
    fixer = Fixer(document.task, catalog)
    assert any(fixer.fixes(issue) for issue in issues)
    for issue in issues:
        fixes = fixer.fixes(issue)
        assert len(fixes) <= MOST
        for fix in fixes:
            after = apply_to_document(document, fix.command).document
            left = [(i.path, i.key) for i in validate(after.task, catalog).issues if i.code == code]
            assert (issue.path, issue.key) not in left, fix.title


@pytest.mark.parametrize("code", ["wrong-parameter-type", "read-before-write", "bad-expression", "ambiguous-target"])
def test_what_only_a_person_knows_has_no_fix(code, catalog):  # noqa: F811
    document = read_text(EXAMPLES[code][0])
    fixer = Fixer(document.task, catalog)
    assert not any(fixer.fixes(issue) for issue in validate(document.task, catalog).issues)
