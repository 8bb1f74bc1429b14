"""Each name in a task that refers to something, misspelt in turn: an error names the place and the right word."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.base.expression import parse_expression
from grip_bt.base.yaml.tree import parse, to_data
from grip_bt.task import read_text
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate

ROOT = Path(__file__).parents[3] / "examples"
OWN = """
grip: 1
name: all_kinds
outcomes: {done: success, lost: failure, given_up: failure}
data: {count: {type: int, value: 0}, seen: {type: "list[int]", value: [1]}, ready: {type: bool, value: true}}
root:
  kind: state_machine
  initial: prepare
  outcomes: {finished: success, missed: failure}
  on: {finished: done, missed: lost}
  children:
    prepare: {kind: retry, times: 2, on: {success: watching, failure.no_plan: trying, failure: missed}, child: {go: {
      kind: timeout, seconds: 3, child: {move: {node: arm/move_to, with: {arm: right, state: home}}}}}}
    watching:
      kind: parallel
      outcomes: {stopped: failure}
      rules: [{when: {walk: failure.no_plan}, then: stopped}, {when: {hold: success}, then: success}, {then: failure}]
      wait_for: [hold]
      on: {success: choosing, stopped: missed, failure: missed}
      children:
        hold: {node: hand/posture, with: {hand: right_hand, posture: flat}}
        walk: {kind: cooldown, seconds: 1, child: {inner: {
          kind: retry, times: 2, child: {walking: {node: arm/move_to, with: {state: home}}}}}}
    choosing:
      kind: switch
      on_value: count
      cases: {zero: 0}
      default: several
      on: {success: trying, failure: missed}
      children: {zero: {node: flow/count, in: {count: count}, out: {count: count}}, several: {node: flow/succeed}}
    trying:
      kind: for_each
      items: seen
      item: each
      precondition: ready
      outcomes: {found: success}
      exits: {guarded.failure.guard: found}
      on: {success: finished, found: finished, failure: missed}
      child: {guarded: {kind: guard, if: each > count, child: {
        log: {node: flow/log, with: {message: m}, in: {value: each}}}}}
"""
UNKNOWABLE = {
    "messages": "what stores hold is known while a run goes on; what nobody has put is the warning unknown-message",
}
"""Nodes of which names aren't checked as errors, and why."""
Place = tuple[str | int, ...]


def misspelt(word: str) -> str:
    """Return a word with one slip of the pen: two letters changed about, or another letter."""
    letters = list(word)
    at = max(i for i, letter in enumerate(word) if letter.isalnum())
    if len(word) > 2 and letters[at] != letters[at - 1]:
        letters[at - 1 : at + 1] = letters[at], letters[at - 1]
    else:
        letters[at] = "z" if letters[at] == "q" else "q"
    return "".join(letters)


def parts_of(text: str) -> Iterator[tuple[str, str]]:
    """Yield each word of `child.outcome.code`, and the text with it misspelt."""
    words = text.split(".")
    for at, word in enumerate(words):
        yield word, ".".join([*words[:at], misspelt(word), *words[at + 1 :]])


def names_in(node: dict[str, Any], catalog: Catalog) -> Iterator[tuple[Place, str, Any]]:
    """Yield, for each name in a node, where it is, the name, and what takes its place; `(..., "key")` for keys."""
    manifest = catalog.get(node["node"]) if "node" in node else None
    if manifest is not None:
        yield ("node",), node["node"], misspelt(node["node"])
        for name, value in node.get("with", {}).items():
            yield ("with", name, "key"), name, misspelt(name)
            if manifest.parameters[name].names in ("arm", "hand", "state", "posture") and value:
                yield ("with", name), value, misspelt(value)
    for key in ("in", "out"):
        for port, variable in node.get(key, {}).items():
            yield (key, port, "key"), port, misspelt(port)
            yield (key, port), variable, misspelt(variable)
    for key in ("on", "exits", "meaning"):
        for end, target in node.get(key, {}).items():
            yield from (((key, end, "key"), word, new) for word, new in parts_of(end))
            if key != "meaning":
                yield (key, end), target, misspelt(target)
    yield from names_of_children(node)
    yield from names_of_variables(node)


def names_of_children(node: dict[str, Any]) -> Iterator[tuple[Place, str, Any]]:
    """Yield likewise where children and their ends are named."""
    for key in ("initial", "default", "items", "task"):
        if node.get(key):
            yield (key,), node[key], misspelt(node[key])
    for child in node.get("cases", {}):
        yield ("cases", child, "key"), child, misspelt(child)
    for number, rule in enumerate(node.get("rules", ())):
        yield ("rules", number, "then"), rule["then"], misspelt(rule["then"])
        for child, said in rule.get("when", {}).items():
            yield ("rules", number, "when", child, "key"), child, misspelt(child)
            if isinstance(said, str):
                yield from ((("rules", number, "when", child), word, new) for word, new in parts_of(said))
    if isinstance(node.get("wait_for"), list):
        for number, child in enumerate(node["wait_for"]):
            yield ("wait_for", number), child, misspelt(child)


def names_of_variables(node: dict[str, Any]) -> Iterator[tuple[Place, str, Any]]:
    """Yield likewise variables of expressions, and types."""
    for key in ("precondition", "if", "while", "on_value"):
        for name in parse_expression(node[key]).names if key in node else ():
            yield (key,), name, re.sub(rf"\b{name}\b", misspelt(name), node[key])
    for variable, said in node.get("data", {}).items():
        type_ = said if isinstance(said, str) else said["type"]
        for name in re.findall(r"[A-Za-z_]+", type_):
            new = type_.replace(name, misspelt(name))
            yield (("data", variable) if isinstance(said, str) else ("data", variable, "type")), name, new


def nodes_of(
    node: dict[str, Any], place: Place = ("root",), path: str = "/"
) -> Iterator[tuple[Place, str, dict[str, Any]]]:
    """Yield each node with its place in the document and its path."""
    yield place, path, node
    for key in ("children", "child"):
        for name, child in node.get(key, {}).items():
            yield from nodes_of(child, (*place, key, name), name if path == "/" else f"{path}/{name}")


def changed(task: dict[str, Any], place: Place, new: Any) -> dict[str, Any]:
    """Return a task with something else at a place."""
    made = deepcopy(task)
    *above, last = place
    if last == "key":
        *above, last = above
    inside: Any = made
    for step in above:
        inside = inside[step]
    if place[-1] == "key":
        entries = {(new if key == last else key): value for key, value in inside.items()}
        inside.clear()
        inside.update(entries)
    else:
        inside[last] = new
    return made


@cache
def catalog() -> Catalog:
    return project_catalog(ROOT)


def tasks() -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the tasks that are shipped, and one with every kind that names something."""
    for file in sorted((ROOT / "tasks").glob("*.yaml")):
        yield file.stem, to_data(parse(file.read_text(), str(file)))  # type: ignore[misc]
    yield "all_kinds", to_data(parse(OWN, "own"))  # type: ignore[misc]


TASKS = dict(tasks())


@pytest.mark.parametrize("name", TASKS)
def test_an_error_names_the_place_and_the_right_word(name: str) -> None:
    task, unseen, asked = TASKS[name], list[str](), 0
    whole = validate(read_text(json.dumps(task), name).task, catalog())
    assert whole.ok, [str(issue) for issue in whole.errors]
    for place, path, node in nodes_of(task["root"]):
        for inside, word, new in names_in(node, catalog()):
            if node.get("node", "").partition("/")[0] in UNKNOWABLE:
                continue
            asked += 1
            document = read_text(json.dumps(changed(task, (*place, *inside), new)), name)
            errors = validate(document.task, catalog(), document).errors
            told = [
                e for e in errors if e.path in (path, "") and re.search(rf"\b{re.escape(word)}\b", e.message + e.fix)
            ]
            if not told:
                unseen.append(f"{path}: {inside}: {word} -> {new}: {[str(e)[-160:] for e in errors][:2]}")
    assert asked > 3
    assert unseen == []
