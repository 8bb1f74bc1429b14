"""The nodes that exist, as an object that is passed around; nothing registers itself."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.base.types import Type

from .equipment import Equipment
from .manifest import Manifest
from .own_code import OwnCode
from .reader import read_manifests
from .subtasks import NoTaskFiles, TaskFiles

_BUILTIN = Path(__file__).parent / "builtin"


class Catalog:
    """Manifests by id.

    Args:
        manifests: no two with the same id.
        tasks: where the files of subtasks are; without it, there are none.

    Attributes:
        tasks: likewise.
        named: returns store -> names of the messages that are there before a run; None where nobody can know.
        equipment: returns what the project's arms, hands and nodes have; None where nobody can know.
        code: what tasks may import besides.

    Raises:
        DocumentError: two manifests have the same id.
    """

    def __init__(self, manifests: Iterable[Manifest] = (), tasks: TaskFiles | None = None):
        self.tasks: TaskFiles = NoTaskFiles() if tasks is None else tasks
        self.named: Callable[[], Mapping[str, Collection[str]] | None] = lambda: None
        self.equipment: Callable[[], Equipment | None] = lambda: None
        self.code = OwnCode()
        self._manifests: dict[str, Manifest] = {}
        for manifest in manifests:
            if manifest.id in self._manifests:
                first = self._manifests[manifest.id].implementation
                raise DocumentError(
                    f"two nodes are called {manifest.id!r}: {first} and {manifest.implementation}; rename one",
                    "catalogue",
                )
            self._manifests[manifest.id] = manifest

    @classmethod
    def builtin(cls) -> Catalog:
        """Return the nodes that come with GRIP."""
        return cls(_builtin_manifests())

    def get(self, id: str, where: str = "") -> Manifest:
        """Return a node's manifest.

        Args:
            id: such as `arm/lift`.
            where: what to name in the error, such as the path of the task's node.

        Raises:
            UnknownNameError: there is no such node; the error names the nearest.
        """
        if id not in self._manifests:
            raise UnknownNameError("node", id, self._manifests, where)
        return self._manifests[id]

    def ids(self) -> tuple[str, ...]:
        """Return the ids, sorted."""
        return tuple(sorted(self._manifests))

    def makers_of(self, type_: Type) -> tuple[str, ...]:
        """Return the ids of nodes that give a value of a type; first what makes one, then what needs the least."""
        found = []
        for manifest in self:
            if any(port.type == type_.name for port in manifest.outputs.values()):
                needed = sum(port.required for port in manifest.inputs.values())
                fails = "failure" in manifest.outcomes.values()
                found.append((not manifest.id.endswith("/make"), needed, fails, len(manifest.outputs), manifest.id))
        return tuple(id for *_, id in sorted(found))

    def with_manifests(self, more: Iterable[Manifest]) -> Catalog:
        """Return a catalogue with more nodes; one of `more` replaces the node of the same id (a mock, for instance).

        Raises:
            DocumentError: two of `more` have the same id.
        """
        made = Catalog(more, self.tasks)
        return self._shared(made, {**self._manifests, **made._manifests})

    def with_tasks(self, tasks: TaskFiles) -> Catalog:
        """Return a catalogue with the same nodes that looks for the files of subtasks in `tasks`."""
        return self._shared(Catalog((), tasks), self._manifests)

    def with_named(self, named: Callable[[], Mapping[str, Collection[str]] | None]) -> Catalog:
        """Return a catalogue with the same nodes that knows the names of messages, or where to look for them."""
        made = self._shared(Catalog((), self.tasks), self._manifests)
        made.named = named
        return made

    def with_equipment(self, equipment: Callable[[], Equipment | None]) -> Catalog:
        """Return a catalogue with the same nodes that knows the parts of a project, or where to look for them."""
        made = self._shared(Catalog((), self.tasks), self._manifests)
        made.equipment = equipment
        return made

    def with_code(self, code: OwnCode) -> Catalog:
        """Return a catalogue with the same nodes whose tasks may import this code."""
        made = self._shared(Catalog((), self.tasks), self._manifests)
        made.code = code
        return made

    def _shared(self, made: Catalog, manifests: dict[str, Manifest]) -> Catalog:
        """Give another catalogue these nodes, and what this one knows of the project."""
        made._manifests, made.named, made.equipment, made.code = manifests, self.named, self.equipment, self.code
        return made

    def __contains__(self, id: object) -> bool:
        return id in self._manifests

    def __iter__(self) -> Iterator[Manifest]:
        return (self._manifests[id] for id in self.ids())

    def __len__(self) -> int:
        return len(self._manifests)


@cache
def _builtin_manifests() -> tuple[Manifest, ...]:
    files = sorted(_BUILTIN.glob("*.yaml"))
    return tuple(manifest for file in files for manifest in read_manifests(file))
