"""Where one variable for a key of a nested container and its parent's key isn't what SMACH's copies do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from .found import FoundContainer


@dataclass
class Sharing:
    """Who writes which variable, and which keys of nested containers are variables of their parents.

    Attributes:
        chain: the containers around what is being made.
        writes: (the containers around a leaf, the variables that it writes).
        shared: (nested container, its key -> variable).
    """

    chain: list[FoundContainer] = field(default_factory=list)
    writes: list[tuple[tuple[FoundContainer, ...], set[str]]] = field(default_factory=list)
    shared: list[tuple[FoundContainer, Mapping[str, str]]] = field(default_factory=list)

    def wrote(self, variables: set[str]) -> None:
        """Note what a leaf of the innermost container writes."""
        self.writes.append((tuple(self.chain), variables))

    def wrote_outside(self, variables: set[str]) -> None:
        """Note what the innermost container writes as a whole."""
        self.writes.append((tuple(self.chain[:-1]), variables))

    def check(self, initial: set[str]) -> None:
        """Note a problem for each key whose copies make a difference.

        Args:
            initial: variables that have a value from the beginning.
        """
        for found, key, text, _ in self.troubles(initial):
            found.problem("partial", f"userdata `{key}` {text}")

    def copied_out(self, initial: set[str]) -> set[tuple[FoundContainer, str]]:
        """Return the keys of containers that need a variable of their own, copied out at the end."""
        return {(found, key) for found, key, _, out in self.troubles(initial) if out}

    def troubles(self, initial: set[str]) -> Iterator[tuple[FoundContainer, str, str, bool]]:
        """Yield container, key, what is wrong, and whether a variable of its own mends it."""
        for found, names in self.shared:
            reads, writes = _inside(found)
            for key, variable in names.items():
                trouble = self._trouble(found, key, variable, reads, writes, initial)
                twins = sorted(k for k, v in names.items() if v == variable)
                if not trouble and len(twins) > 1 and writes & set(twins):
                    trouble = f"and {[k for k in twins if k != key]} are one key of the parent: SMACH keeps them apart"
                if trouble:
                    mends = len(twins) > 1 or (key in found.output_keys and key not in found.input_keys)
                    yield found, key, f"{trouble}, the task has one variable, `{variable}`", mends

    def _trouble(
        self, found: FoundContainer, key: str, variable: str, reads: set[str], writes: set[str], initial: set[str]
    ) -> str:
        comes, goes = key in found.input_keys, key in found.output_keys
        if comes and not goes and key in writes:
            return f"comes in and not out, but a state writes it: SMACH drops that when the {found.kind} ends"
        if goes and not comes:
            others = any(found not in chain and variable in written for chain, written in self.writes)
            if others:
                return f"goes out and not in, and is written elsewhere too: SMACH keeps the {found.kind}'s own value"
            if key in reads and variable in initial:
                return f"goes out and not in, but a state reads it: SMACH shows it what the {found.kind} has written"
        return ""


def copied_in(found: FoundContainer) -> list[str]:
    """Return the keys of a machine that need a variable of their own: they come in and not out, and are written."""
    writes = _inside(found)[1]
    return [key for key in found.input_keys if key in writes and key not in found.output_keys]


def _inside(found: FoundContainer) -> tuple[set[str], set[str]]:
    """Return the keys of a container that its children read and write."""
    reads: set[str] = set()
    writes: set[str] = set()
    for added in found.added.values():
        remapping = {} if found.kind == "Iterator" else added.remapping
        reads |= {remapping.get(key, key) for key in added.state.input_keys}
        writes |= {remapping.get(key, key) for key in added.state.output_keys}
    if found.kind == "Iterator":
        writes.add(str(found.settings.get("it_label", "it_data")))
    return reads, writes
