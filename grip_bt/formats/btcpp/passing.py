"""What an imported task needs besides to pass the checks, and to mean what it meant.

* Children of a parallel that share variables are in order, as all children are in BT.CPP.
* Variables may be read before they are surely written: in BT.CPP such an entry isn't there yet. A port then reads
  nothing, and a Switch takes its default, as both do here with null. A script ends with an exception; that stays an
  error of the task, which `grip check` names.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from grip_bt.base.expression import parse_expression
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.issue import Issue
from grip_bt.task import model, walking
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate


def with_nulls(task: model.Task, catalog: Catalog) -> tuple[model.Task, list[str]]:
    """Return the task with null in the variables that only ports and Switches read too early, and their names."""
    issues = [issue for issue in validate(task, catalog).issues if issue.code == "read-before-write"]
    nodes = dict(walking.walk(task.root))
    patient, strict = set[str](), set[str]()
    for issue in issues:
        names, mild = _read(nodes[issue.path], issue)
        (patient if mild else strict).update(names)
    early = [name for name in task.data if name in patient - strict]
    null = model.Variable(type="Any", value=None)
    data = {name: null if name in early else variable for name, variable in task.data.items()}
    return (task.model_copy(update={"data": FrozenDict(data)}) if early else task), early


def in_order(task: dict[str, Any], catalog: Catalog) -> dict[str, Any]:
    """Return a task's keys with `order: declared` in parallels whose children share variables, as all do in BT.CPP."""
    for issue in validate(model.Task.model_validate(task), catalog).issues:
        if issue.code in ("parallel-writes", "parallel-read-write"):
            keys = task["root"]
            for name in issue.path.split("/") if issue.path != "/" else ():
                keys = keys.get("children", keys.get("child"))[name]
            keys["order"] = "declared"
    return task


def _read(node: model.AnyNode, issue: Issue) -> tuple[Iterable[str], bool]:
    """Return the variables that an issue is about, and whether their reader takes null for nothing."""
    key = issue.key[0] if issue.key else ""
    if isinstance(node, model.Leaf) and key == "in":
        return [node.in_[str(issue.key[1])]], node.node != "flow/compute"
    texts = dict(walking.expressions_of(node))
    names = parse_expression(texts[str(key)]).names if key in texts else ()
    return names, key == "on_value" and texts["on_value"] in names
