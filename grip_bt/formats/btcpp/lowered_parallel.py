"""Parallels as BehaviorTree.CPP's: children that wait when they have ended, and one that decides on every tick."""

from __future__ import annotations

from typing import TYPE_CHECKING

from grip_bt.compilers.resolve import Part
from grip_bt.task import model

from .lowered import Xml, all_of, any_of, around, chosen, holds, labelled, leads, script

if TYPE_CHECKING:
    from .lowering import Lowering


def parallel(work: Lowering, part: Part, node: model.Parallel) -> Xml:
    """Return a parallel whose children wait when they have ended, until somebody decides."""
    if not part.children:
        raise work.refuse(part, "a parallel without children")
    done, code = work.entry("done"), work.entry("why")
    ended = {child.name: work.entry("ended") for child in part.children}
    labels = {child.name: work.entry("label") for child in part.children}
    codes = {child.name: work.entry("because") for child in part.children}
    first = [f"{done} := ''", f"{code} := ''"]
    for child in part.children:
        first += [f"{ended[child.name]} := 0", f"{labels[child.name]} := ''", f"{codes[child.name]} := ''"]
    asking = node.cancel == "ask"
    if asking:
        asked = work.entry("asked")
        first.append(f"{asked} := false")
        work.asked.append(asked)
    decide = decision(part, node, done, code, ended, labels, codes)
    if asking:  # what is decided stays, and is said to all leaves, until they have ended
        decide = [f"{to} := ({asked} ? {to} : ({value}))" for to, value in (each.split(" := ", 1) for each in decide)]
        decide.append(f"{asked} := ({done} != '')")
    idle = around("KeepRunningUntilFailure", Xml("AlwaysSuccess"))
    ways = []
    for child in part.children:
        name = child.name
        note = [f"{ended[name]} := 1", f"{labels[name]} := outcome", f"{codes[name]} := code"]
        run = around("ForceSuccess", work.node(child))
        if node.retick:
            again = around("Sequence", script(f"{ended[name]} := 0", f"{labels[name]} := ''"), run, script(*note))
            ways.append(around("KeepRunningUntilFailure", again))
        elif node.prompt:
            now = around("Fallback", around("Sequence", script(*decide), holds(f"{done} != ''")), idle)
            ways.append(around("Sequence", run, script(*note), now))
        else:
            ways.append(around("Sequence", run, script(*note), idle))
    waits = f"{done} == ''" if not asking else f"{done} == '' || !{all_of(f'{each} == 1' for each in ended.values())}"
    waiting = around("Sequence", script(*decide), holds(waits))
    if asking:
        work.asked.pop()
    ways.append(around("Inverter", around("KeepRunningUntilFailure", waiting)))
    body = around("Parallel", *ways, success_count="1", failure_count=str(len(ways)))
    ending = script(f"outcome := {done}", f"code := {code}")
    return around("Sequence", script(*first), around("ForceSuccess", body), ending, work.verdict(done, part.meaning))


def decision(
    part: Part,
    node: model.Parallel,
    done: str,
    code: str,
    ended: dict[str, str],
    labels: dict[str, str],
    codes: dict[str, str],
) -> list[str]:
    """Return assignments that note how a parallel ends, and why it fails."""
    children = part.children
    every = all_of(f"{ended[c.name]} == 1" for c in children)
    wait = node.wait_for
    number = " + ".join(ended.values())
    match wait if node.cancel != "join" else "all":
        case None:
            waited = "true"
        case "all":
            waited = every
        case "any":
            waited = f"({number} >= 1)"
        case int(least):
            waited = f"(({number} >= {least}) || {every})"
        case names:
            waited = f"({all_of(f'{ended[n]} == 1' for n in names)} || {every})"
    complete = "true" if wait is not None else every

    def of_meaning(child: Part, meaning: str) -> str:
        return any_of(
            f"{labels[child.name]} == '{label}'" for label, means in child.meaning.items() if means == meaning
        )

    ways: list[tuple[str, str]] = []
    for child in children:
        ways += leads(part.exits, child, "'", labels[child.name], codes[child.name])
    for rule in node.rules:
        asked = [] if rule.when or rule.at_least is not None else [complete]
        for name, said in rule.when.items():
            child = next(c for c in children if c.name == name)
            each = [said] if isinstance(said, str) else said
            asked.append(any_of(labelled(one, labels[child.name], codes[child.name]) for one in each))
        if rule.at_least is not None:
            counts = [f"({of_meaning(c, rule.ends)} ? 1 : 0)" for c in children]
            asked.append(f"({' + '.join(counts)} >= {rule.at_least})")
        ways.append((all_of(asked), f"'{rule.then}'"))
    one, all_ = ("failure", "success") if node.policy == "all" else ("success", "failure")
    single = any_of(of_meaning(c, one) for c in children)
    natural = [(single, f"'{one}'"), (complete, f"'{all_}'")]
    ways += [(f"({complete} && {asked})", to) for asked, to in natural] if node.rules else natural
    why: list[tuple[str, str]] = []
    for child in children:
        for taken, to in leads(part.exits, child, "'", labels[child.name], codes[child.name]):
            why.append((f"({taken} && {done} == {to})", codes[child.name]))
    why += [(of_meaning(c, "failure"), codes[c.name]) for c in children]
    none = "''"
    return [f"{done} := ({waited} ? ({chosen(ways, none)}) : '')", f"{code} := {chosen(why, none)}"]
