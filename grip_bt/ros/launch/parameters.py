"""Parameters of a node in a launch file, as arguments of its program."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from .element import Element
from .hints import TYPES
from .substitutions import Place, truth

_SEPARATED = "value-sep"


def parameters_of(element: Element, text: Callable[..., str], place: Place) -> list[str]:
    """Return the arguments behind `--ros-args` for one `<param>`: a value, nested ones, or a file.

    Raises:
        LaunchError: it says neither, or its file isn't there.
    """
    if "from" in element.attributes:
        file = Path(text(element, "from"))
        if not file.is_file():
            raise place.error(f"<param from=...>: there is no file {file}")
        if truth(text(element, "allow_substs", "false"), place, "`allow_substs`"):
            reason = "substitutions in a file of parameters aren't made here; give those as <param name= value=>"
            raise place.error(f"<param from=... allow_substs=...>: {reason}")
        return ["--params-file", str(file)]
    made: list[str] = []
    for name, value in _values(element, text, place, ""):
        made += ["-p", f"{name}:={value}"]
    return made


def _values(element: Element, text: Callable[..., str], place: Place, above: str) -> Iterator[tuple[str, str]]:
    name = above + text(element, "name")
    if element.children:
        for child in element.children:
            if child.tag != "param":
                raise place.error(f"<{child.tag}> can't stand in <param>")
            yield from _values(child, text, place, f"{name}.")
    elif _SEPARATED in element.attributes:
        items = text(element, "value").split(text(element, _SEPARATED))
        yield name, "[" + ", ".join(item.strip() for item in items) + "]"
    else:
        yield name, _typed(text(element, "value"), text(element, "type", ""), place)


def _typed(value: str, type_: str, place: Place) -> str:
    if type_ in ("", "int", "float", "bool", "yaml"):
        return value if value else "''"
    if type_ == "str":
        return "'" + value.replace("'", "''") + "'"
    meant = f"; write {TYPES[type_]!r}" if type_ in TYPES else ""
    raise place.error(f"<param type={type_!r}> isn't understood here{meant} (what is: int, float, bool, str, yaml)")
