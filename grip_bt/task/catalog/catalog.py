"""The nodes that exist, as an object that is passed around; nothing registers itself."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from copy import copy
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import ModuleType

from grip_bt.base.errors import DocumentError, ImplementationError, UnknownNameError

from .manifest import Manifest, read_manifests
from .project_parts import ProjectParts
from .source_code import AllowedImports
from .task_files import NO_TASK_FILES, TaskFiles


def load_implementation(manifest: Manifest) -> type:
    """Import the class that `manifest.implementation` names.

    `package.module:Class` is imported as usual; `/folder/file.py:Class` is loaded once per process under a name
    of its own, so that two components may both have a `leaf.py`.

    Raises:
        ImplementationError: the module isn't there or can't be imported, or the name isn't a class.
        UnknownNameError: the module has no such class.
    """
    where, colon, name = manifest.implementation.rpartition(":")
    if not colon or not where or not name.isidentifier():
        raise ImplementationError(
            manifest.id, manifest.implementation, "write `package.module:Class` or `file.py:Class`"
        )
    module = _import(manifest, where)
    found = getattr(module, name, None)
    if found is None:
        classes = [k for k, v in vars(module).items() if isinstance(v, type) and k[0] != "_"]
        raise UnknownNameError("class", name, classes, f"node {manifest.id}, {where}")
    if not isinstance(found, type):
        raise ImplementationError(
            manifest.id, manifest.implementation, f"{name} is a {type(found).__name__}, not a class"
        )
    return found


def _import(manifest: Manifest, where: str) -> ModuleType:
    try:
        return _import_file(Path(where)) if where.endswith(".py") else importlib.import_module(where)
    except ModuleNotFoundError as error:
        if error.name and (where == error.name or where.startswith(f"{error.name}.")):
            reason = f"there is no module {error.name!r}; is its package installed?"
        else:
            reason = f"it needs {error.name!r}, which isn't installed here"
            if manifest.id.startswith("smach/"):
                reason += "; a dry run does without it: grip run --stand-ins"
        raise ImplementationError(manifest.id, manifest.implementation, reason) from error
    except FileNotFoundError as error:
        reason = "there is no such file; generate the node again, or correct the manifest"
        raise ImplementationError(manifest.id, manifest.implementation, reason) from error
    except Exception as error:
        reason = f"importing it raised {type(error).__name__}: {error}"
        raise ImplementationError(manifest.id, manifest.implementation, reason) from error


def _import_file(file: Path) -> ModuleType:
    file = file.resolve()
    name = f"grip_node_{sha256(str(file).encode()).hexdigest()[:12]}"
    if name in sys.modules:
        return sys.modules[name]
    if not file.is_file():
        raise FileNotFoundError(file)
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


_BUILTIN = Path(__file__).parent / "builtin"


class Catalog:
    """Manifests by id.

    Args:
        manifests: no two with the same id.

    Attributes:
        named: returns store -> names of the messages that are there before a run; None where nobody can know.
        parts: returns what the project's arms, hands and nodes have; None where nobody can know.
        code: what tasks may import besides.

    Raises:
        DocumentError: two manifests have the same id.
    """

    def __init__(self, manifests: Iterable[Manifest] = (), tasks: TaskFiles | None = None):
        self.tasks: TaskFiles = tasks or NO_TASK_FILES
        self.named: Callable[[], Mapping[str, Collection[str]] | None] = lambda: None
        self.parts: Callable[[], ProjectParts | None] = lambda: None
        self.code = AllowedImports()
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
        made = copy(self)
        made._manifests = {**self._manifests, **Catalog(more)._manifests}
        return made

    def with_(
        self,
        *,
        tasks: TaskFiles | None = None,
        named: Callable[[], Mapping[str, Collection[str]] | None] | None = None,
        parts: Callable[[], ProjectParts | None] | None = None,
        code: AllowedImports | None = None,
    ) -> Catalog:
        """Return a catalogue with the same nodes and other attributes, where they are given."""
        made = copy(self)
        made.tasks, made.named = tasks or self.tasks, named or self.named
        made.parts, made.code = parts or self.parts, code or self.code
        return made

    def __contains__(self, id: object) -> bool:
        return id in self._manifests

    def __iter__(self) -> Iterator[Manifest]:
        return (self._manifests[id] for id in self.ids())


@cache
def _builtin_manifests() -> tuple[Manifest, ...]:
    files = sorted(_BUILTIN.glob("*.yaml"))
    return tuple(manifest for file in files for manifest in read_manifests(file))
