"""Where labels lead: edges keyed by (child, outcome, code or none), the most specific first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

Key = tuple[str, str, str | None]


class Edges:
    """A table from a child's end to a target: a sibling's name or one of the container's outcomes.

    Args:
        table: (child, outcome, code) -> target; code None stands for every code and for none.
    """

    def __init__(self, table: Mapping[Key, str] | None = None):
        self.table = dict(table or {})

    @classmethod
    def of_exits(cls, exits: Mapping[str, str]) -> Edges:
        """Read `child.outcome` and `child.outcome.code`."""
        return cls({_key(*label.split(".", 2)): target for label, target in exits.items()})

    @classmethod
    def of_children(cls, on: Mapping[str, Mapping[str, str]]) -> Edges:
        """Read each child's own `outcome` and `outcome.code`."""
        return cls(
            {
                _key(child, *label.split(".", 1)): target
                for child, labels in on.items()
                for label, target in labels.items()
            }
        )

    def target(self, child: str, outcome: str, code: str | None = None) -> str | None:
        """Return where this end leads, or None where no edge leaves."""
        if code is not None:
            found = self.table.get((child, outcome, code))
            if found is not None:
                return found
        return self.table.get((child, outcome, None))

    def codes(self, child: str, outcome: str) -> Iterator[str]:
        """Yield the codes that refine this outcome of the child."""
        return (code for c, o, code in self.table if (c, o) == (child, outcome) and code)

    def __iter__(self) -> Iterator[tuple[Key, str]]:
        return iter(self.table.items())

    def __bool__(self) -> bool:
        return bool(self.table)


def _key(child: str, outcome: str = "", code: str | None = None) -> Key:
    return child, outcome, code
