"""What a component's answer is called: its outcome."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from grip_bt.base.evaluation import condition_of
from grip_bt.base.expression import parse_expression
from grip_bt.task.catalog.component_file import ComponentFile


def label_of(component: ComponentFile, reply: Mapping[str, Any]) -> str:
    """Return how an answer is called: by its number, or by the outcomes' rules.

    Args:
        component: whose answer it is.
        reply: outputs, and the `outcome` of a contract.
    """
    if not component.rules:
        return f"{component.outcomes[reply['outcome']]!r} ({reply['outcome']})"
    for label, text in component.rules.items():
        rule = parse_expression(text)
        if condition_of(rule, {name: partial(reply.__getitem__, name) for name in rule.names})():
            return repr(label)
    return "no rule holds"
