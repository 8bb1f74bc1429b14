"""From a manifest to the class of its leaf; the one place where a node's code is imported."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from hashlib import sha256
from pathlib import Path
from types import ModuleType

from grip_bt.base.errors import ImplementationError, UnknownNameError

from .manifest import Manifest


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
            manifest.id,
            manifest.implementation,
            "write `package.module:Class` or `file.py:Class`",
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
