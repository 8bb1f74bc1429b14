"""Which variable a `{key}` is: sub-trees see their own names, or those that they are given."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from ..pytrees.naming import node_name

_KEY = re.compile(r"\{([^{}]+)\}")


@dataclass(frozen=True)
class Constant:
    """A value that a sub-tree was given in place of a variable."""

    text: str


@dataclass
class Variables:
    """The variables of a whole file: name -> types that its ports want, who writes it first."""

    types: dict[str, list[str]] = field(default_factory=dict)
    constants: dict[str, tuple[str, object]] = field(default_factory=dict)

    def use(self, name: str, type_name: str, *, written: bool) -> None:
        """Note that a port of this type is bound to a variable; a writer's type counts before a reader's."""
        types = self.types.setdefault(name, [])
        types.insert(0 if written else len(types), type_name)

    def constant(self, name: str, type_name: str, value: object) -> str:
        """Declare a variable for a value that is given to an input port; return its name."""
        number, unique = 2, name
        while unique in self.types or self.constants.get(unique, (type_name, value)) != (type_name, value):
            unique, number = f"{name}_{number}", number + 1
        self.constants[unique] = (type_name, value)
        return unique

    def declared(self) -> dict[str, object]:
        """Return the task's `data`."""
        known: dict[str, object] = {name: types[0] for name, types in self.types.items()}
        return known | {name: {"type": type_, "value": value} for name, (type_, value) in self.constants.items()}


@dataclass
class Names:
    """What the keys of one sub-tree mean.

    Attributes:
        space: names of the sub-trees around, the outermost first.
        given: key -> variable of the file, or a constant.
    """

    space: tuple[str, ...] = ()
    given: dict[str, str | Constant] = field(default_factory=dict)

    def meaning(self, text: str) -> str | Constant:
        """Return the variable that an attribute names, or the constant that it is.

        Raises:
            ValueError: braces don't stand around the whole of it.
        """
        found = _KEY.fullmatch(text)
        if found is None:
            if "{" in text or "}" in text:
                raise ValueError(f"{text!r} isn't a key; write {{key}} and nothing else")
            return Constant(text)
        key = found.group(1)
        if key not in self.given:
            self.given[key] = node_name("_".join((*self.space, key)))
        return self.given[key]
