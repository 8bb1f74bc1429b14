"""What settings files share: their base class, and the spelling of names in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

from pydantic import BaseModel, ConfigDict, StringConstraints

Identifier = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$")]
RosName = Annotated[str, StringConstraints(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)+$")]
"""A whole name: of a topic, service, action or namespace."""


class Settings(BaseModel):
    """A part of a settings file: frozen, and nothing else is allowed in it."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


def exactly_one(settings: Settings, keys: Sequence[str], shown: str = "") -> None:
    """Check that one of several keys is given.

    Args:
        settings: what has the keys.
        keys: their names.
        shown: how the choice is written where the keys alone don't tell it.

    Raises:
        ValueError: none of them is given, or several are.
    """
    given = [key for key in keys if getattr(settings, key)]
    if len(given) != 1:
        here = " and ".join(given) or "none of them"
        raise ValueError(f"give exactly one of {shown or ', '.join(f'`{key}`' for key in keys)}; here: {here}")
