"""The nodes that exist, as an object that is passed around; nothing registers itself."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from grip_bt.errors import DocumentError, UnknownNameError

from .manifest import Manifest
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

    Raises:
        DocumentError: two manifests have the same id.
    """

    def __init__(self, manifests: Iterable[Manifest] = (), tasks: TaskFiles | None = None):
        self.tasks: TaskFiles = NoTaskFiles() if tasks is None else tasks
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

    def with_manifests(self, more: Iterable[Manifest]) -> Catalog:
        """Return a catalogue with more nodes; one of `more` replaces the node of the same id (a mock, for instance).

        Raises:
            DocumentError: two of `more` have the same id.
        """
        made = Catalog(more, self.tasks)
        made._manifests = {**self._manifests, **made._manifests}
        return made

    def with_tasks(self, tasks: TaskFiles) -> Catalog:
        """Return a catalogue with the same nodes that looks for the files of subtasks in `tasks`."""
        made = Catalog((), tasks)
        made._manifests = self._manifests
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
