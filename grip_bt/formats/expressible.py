"""Whether a format has words for a node: what it can't say is refused by name."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from grip_bt.base.errors import NotExpressibleError
from grip_bt.task import model


def require_expressible(
    path: str, node: model.AnyNode, known: Mapping[type, Collection[str]], target: str, common: Collection[str] = ()
) -> None:
    """Refuse a node whose kind has no equivalent, or that says more than the format can.

    Args:
        known: class of a node -> the fields that the format can say.
        common: fields that it can say of every node.

    Raises:
        NotExpressibleError: it names the node and the field.
    """
    kind = getattr(node, "kind", "leaf")
    fields = known.get(type(node))
    if fields is None:
        raise NotExpressibleError(path, f"a {kind}", target)
    for name, info in type(node).model_fields.items():
        if name in fields or name in common:
            continue
        if getattr(node, name) != info.get_default(call_default_factory=True):
            said = name if info.alias in (None, "*") else info.alias  # `*`: free data, whatever it is called
            raise NotExpressibleError(path, f"`{said}` of a {kind}", target)
