"""An exit to an outcome that isn't declared is an issue wherever it stands, and never breaks the other rules."""

import pytest

from grip_bt.task import loads
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate

CHILD = "{kind: sequence, exits: {s.success: lost}, children: {s: {node: flow/succeed}}}"
ROOTS = (
    CHILD,
    f"{{kind: retry, times: 2, child: {{a: {CHILD}}}}}",
    f"{{kind: sequence, children: {{a: {CHILD}, b: {{node: flow/succeed}}}}}}",
    f"{{kind: parallel, children: {{a: {CHILD}}}}}",
    f"{{kind: switch, on_value: '1', cases: {{a: 1}}, children: {{a: {CHILD}}}}}",
    f"{{kind: state_machine, initial: a, outcomes: {{success: success}}, children: {{a: {CHILD}}}}}",
)


@pytest.mark.parametrize("root", ROOTS)
def test_an_exit_to_nowhere_is_an_issue_in_every_container(root):
    report = validate(loads(f"grip: 1\nname: a\nroot: {root}\n"), Catalog.builtin())
    assert any("'lost'" in issue.message for issue in report.errors)
