"""Named messages that a task reads: whether anybody has put them there."""

from __future__ import annotations

from collections.abc import Iterator

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Leaf

from ..survey import Spot, Survey
from ..wording import take_hint

READ, PUT = "messages/get", "messages/put"


def check_messages(survey: Survey) -> None:
    """Find messages that are read by name, and that are neither in the project nor put by the task."""
    read = [spot for spot in survey.leaves if isinstance(spot.node, Leaf) and spot.node.node == READ]
    names = known_messages(survey) if read else None
    if names is None:
        return
    for spot in read:
        store, name = _place(spot)
        if isinstance(store, str) and isinstance(name, str) and name not in names.get(store, ()):
            there = names.get(store, ())
            hint = nearest(name, there)
            known_ones = f" (there are: {listing(there)})" if there else ""
            survey.add(
                spot.path,
                ("with", "name"),
                "unknown-message",
                f"nothing is called {name!r} in the store {store!r}{hint}{known_ones}",
                take_hint(hint, f"add it to the project's messages, or put it first: `node: {PUT}`"),
            )


def known_messages(survey: Survey) -> dict[str, set[str]] | None:
    """Return store -> names of the messages that are there, or that the task puts; None if nobody knows."""
    known = survey.catalog.named()
    if known is None:
        return None
    names = {store: set(there) for store, there in known.items()}
    for store, name in _put(survey.leaves):
        names.setdefault(store, set()).add(name)
    return names


def _put(leaves: list[Spot]) -> Iterator[tuple[str, str]]:
    for spot in leaves:
        if isinstance(spot.node, Leaf) and spot.node.node == PUT:
            store, name = _place(spot)
            if isinstance(store, str) and isinstance(name, str):
                yield store, name


def _place(spot: Spot) -> tuple[object, object]:
    assert isinstance(spot.node, Leaf), "leaves read and put messages"
    return spot.node.with_.get("store"), spot.node.with_.get("name")
