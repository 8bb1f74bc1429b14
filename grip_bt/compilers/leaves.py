"""Making the leaves of a task: implementation, parameters, ports bound to variables."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from typing import Any, cast

from py_trees.behaviour import Behaviour

from grip_bt.base.errors import ImplementationError, NodeError
from grip_bt.nodes.leaf import Leaf
from grip_bt.task import model
from grip_bt.task.catalog import Manifest, load_implementation

from .resolve import Part
from .scopes import Cell, Scopes

_log = logging.getLogger(__name__)

LeafFactory = Callable[[str, model.Leaf, Manifest], Leaf]
"""(path, what the document says, manifest) -> a leaf, not bound yet."""


def implementation_of(path: str, node: model.Leaf, manifest: Manifest) -> Leaf:
    """Make a leaf of the class that its manifest names, with the defaults of its parameters filled in."""
    defaults = {name: p.default for name, p in manifest.parameters.items() if not p.required}
    implementation = load_implementation(manifest)
    if not issubclass(implementation, Behaviour):  # before it is called: a manifest may name any class there is
        reason = f"{implementation.__name__} is no class of nodes; derive it from `grip_bt.nodes.Leaf`"
        raise ImplementationError(manifest.id, manifest.implementation, reason)
    name = path.rsplit("/", 1)[-1] or manifest.id
    return cast(Leaf, implementation(name, path, manifest, {**defaults, **node.with_}, dict(node.meaning)))


def make_leaf(part: Part, factory: LeafFactory, scopes: Scopes) -> Leaf:
    """Make one leaf and bind its ports to the cells of its variables."""
    node = cast(model.Leaf, part.node)
    assert part.manifest is not None, "resolved leaves have a manifest"
    leaf = factory(part.path, node, part.manifest)
    leaf.name = part.name
    for port, variable in node.in_.items():
        leaf.readers[port] = scopes.reader(part.path, port, _cell(part, variable))
    for port, variable in node.out.items():
        leaf.writers[port] = scopes.writer(part.path, port, _cell(part, variable))
    return leaf


def _cell(part: Part, variable: str) -> Cell:
    cell = part.scope.find(variable)
    assert cell is not None, "resolved variables are declared"
    return cell


def prepare(nodes: Iterable[Behaviour], context: Any) -> None:
    """Set up nodes, each once.

    Raises:
        NodeError: one raised; it is named.
    """
    for node in nodes:
        try:
            node.setup(context=context)
        except Exception as error:
            raise NodeError(getattr(node, "path", node.name), error) from error


def release(nodes: Iterable[Behaviour]) -> None:
    """Undo `prepare` as far as nodes can; what one raises is logged, since nobody could do anything about it."""
    for node in nodes:
        try:
            node.shutdown()
        except Exception:  # noqa: BLE001 - the run has ended, with a result that this must not replace
            _log.exception("shutdown of %s", getattr(node, "path", node.name))
