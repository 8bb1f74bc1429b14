"""Chains and loops -> sequences, fallbacks and repeats, whose labelled exits lead where the machine's edges led."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from grip_bt.base.frozen import FrozenDict
from grip_bt.task.edit.paste import fresh_name
from grip_bt.task.model import AnyNode, Fallback, Force, Meaning, Repeat, Sequence, StateMachine

from ..resolve import Part
from .regions import Arc, Chain, Loop, Region, State
from .result import Built, Place, common

PLAIN: Mapping[str, Meaning] = {"success": "success", "failure": "failure"}


@dataclass(frozen=True)
class Item:
    """A new child.

    Attributes:
        places: old child of the machine -> its names, beginning with `name`.
    """

    name: str
    node: AnyNode
    ends: tuple[Arc, ...]
    places: Mapping[str, Place]

    def goes_on(self, target: str, meaning: str) -> bool:
        """Tell whether ends for `target` are just those that a container goes on with, without a label for them."""
        here = {(end.outcome, end.code): end for end in self.ends}
        return all(
            end.meaning == meaning and here.get((end.outcome, None), end).target == target
            for end in self.ends
            if end.target == target
        )


Meanings = Mapping[str, str]
"""State outside a region -> the meaning that its label shall have: that with which the container above goes on."""


class Composer:
    """Makes the composites of one state machine."""

    def __init__(self, part: Part, children: Mapping[str, Built]):
        self.part, self.children = part, children
        self.taken = set(children) | set(part.meaning) | set(PLAIN)
        self.labels = {name: self.labelled(name) for name in children}

    def build(self, region: Region) -> Built:
        old = self.part.node
        assert isinstance(old, StateMachine), "only a machine has regions"
        body = self.container(region, {})
        places: dict[str, Place] = {self.part.path: ()}
        for state, place in body.places.items():
            places.update(self.children[state].below(place))
        outcomes = FrozenDict({k: v for k, v in old.outcomes.items() if k not in PLAIN})
        return Built(body.node.model_copy(update={**common(old), "outcomes": outcomes}), places)

    def item(self, region: Region, meanings: Meanings) -> Item:
        if isinstance(region, State):
            return self.state(region)
        made = self.container(region, meanings)
        ends = self.ends(region.leaving, meanings)
        name = f"repeat_{region.entry}" if isinstance(region, Loop) else f"{region.entry}_then_{region.last}"
        return self.named(name, made.node, ends, made.places)

    def state(self, region: State) -> Item:
        node = self.children[region.entry].node.model_copy(update={"on": FrozenDict()})
        return Item(region.entry, node, region.leaving, {region.entry: (region.entry,)})

    def container(self, region: Region, meanings: Meanings) -> Item:
        match region:
            case State():
                items, goes_on = [self.state(region)], "success"
            case Chain():
                items, goes_on = list(self.parts_of(region, meanings)), region.goes_on
            case Loop():
                items, goes_on = [self.continuing(region.body, region.entry, "success", meanings)], "success"
        following = [part.entry for part in region.parts[1:]] if isinstance(region, Chain) else []
        if isinstance(region, Loop):
            following = [region.entry]
        exits = dict(self.exits(items, following, goes_on))
        used = {label: target for item in items for target in targets(item.ends) for label in (self.label(target),)}
        outcomes = {k: self.meaning(t, meanings) for k, t in used.items() if k in exits.values() and k not in PLAIN}
        content = {
            "outcomes": FrozenDict(outcomes),
            "exits": FrozenDict(exits),
            "child" if isinstance(region, Loop) else "children": FrozenDict({i.name: i.node for i in items}),
        }
        kind = Repeat if isinstance(region, Loop) else Sequence if goes_on == "success" else Fallback
        node = kind(kind=kind.__name__.lower(), **content)
        return Item("", node, (), {state: place for item in items for state, place in item.places.items()})

    def parts_of(self, chain: Chain, meanings: Meanings) -> Iterator[Item]:
        for part, following in zip(chain.parts, chain.parts[1:], strict=False):
            yield self.continuing(part, following.entry, chain.goes_on, meanings)
        yield self.item(chain.parts[-1], meanings)

    def continuing(self, region: Region, target: str, meaning: str, meanings: Meanings) -> Item:
        """Return a child whose ends for `target` all have a meaning by which its container goes on."""
        item = self.item(region, {**meanings, target: meaning})
        if item.goes_on(target, meaning):
            return item
        return self.wrapped(item, {**meanings, target: meaning})

    def wrapped(self, item: Item, meanings: Meanings) -> Item:
        """Return the child in a container that gives each of its targets a label of its own."""
        places = item.places
        reached = targets(item.ends)
        only = FrozenDict({item.name: item.node})
        if len(reached) == 1:
            meaning: Meaning = "success" if meanings[reached[0]] == "success" else "failure"
            forced = Force(kind=Force.kind_name(), as_=meaning, child=only)
            return self.named(f"try_{item.name}", forced, (Arc(item.name, meaning, None, meaning, reached[0]),), places)
        ends = self.ends(item.ends, meanings)
        exits = FrozenDict(dict(self.exits([item], [], "success")))
        outcomes = FrozenDict({e.outcome: e.meaning for e in ends if e.outcome not in PLAIN})
        node = Sequence(kind=Sequence.kind_name(), outcomes=outcomes, exits=exits, children=only)
        return self.named(f"try_{item.name}", node, ends, places)

    def named(self, name: str, node: AnyNode, ends: tuple[Arc, ...], places: Mapping[str, Place]) -> Item:
        free = fresh_name(name, self.taken)
        self.taken.add(free)
        return Item(free, node, ends, {state: (free, *place) for state, place in places.items()})

    def exits(self, items: list[Item], following: list[str], goes_on: str) -> Iterator[tuple[str, str]]:
        """Yield the exits: every end that doesn't go on, unless its meaning leads there without one."""
        for number, item in enumerate(items):
            onward = following[number] if number < len(following) else None
            coded = {end.outcome for end in item.ends if end.code is not None}
            for end in sorted(item.ends, key=_code_first(item)):
                if end.target == onward:
                    continue
                by_meaning = end.meaning if onward is None or end.meaning != goes_on else None
                label = self.label(end.target)
                if end.code is None and end.outcome not in coded and label == by_meaning:
                    continue
                yield f"{item.name}.{end.label}", label

    def ends(self, leaving: Iterable[Arc], meanings: Meanings) -> tuple[Arc, ...]:
        return tuple(Arc("", self.label(t), None, self.meaning(t, meanings), t) for t in targets(leaving))

    def label(self, target: str) -> str:
        return self.labels.get(target, target)

    def labelled(self, state: str) -> str:
        """Return a label for a state that no outcome and no other state has."""
        label = state
        while label in self.part.meaning or label in PLAIN or (label != state and label in self.children):
            label += "_next"
        return label

    def meaning(self, target: str, meanings: Meanings) -> str:
        return meanings[target] if target in self.children else self.part.meaning[target]


def _code_first(item: Item) -> Callable[[Arc], tuple[int, bool]]:
    """Return a key that keeps the order of outcomes and puts their codes before them, as people write it."""
    outcomes = [end.outcome for end in item.ends]
    return lambda end: (outcomes.index(end.outcome), end.code is None)


def targets(ends: Iterable[Arc]) -> list[str]:
    """Return the different targets of ends, in order."""
    return list(dict.fromkeys(end.target for end in ends))
