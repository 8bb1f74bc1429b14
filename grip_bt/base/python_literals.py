"""The one way in which a value enters generated Python: as a literal that reads back as the same value."""

from __future__ import annotations

import re

_ESCAPE_OR_QUOTE = re.compile(r"\\.|\"", re.DOTALL)


def py(value: object) -> str:
    """Return a Python literal for a string, a number, a bool, None, or a list, tuple or dict of such.

    Strings are in double quotes unless these need more escapes than single ones, as formatters want it.

    Raises:
        TypeError: the value isn't a literal.
    """
    if isinstance(value, str):
        text = repr(value)
        if text[0] == '"' or value.count('"') > value.count("'"):
            return text
        return f'"{_ESCAPE_OR_QUOTE.sub(_for_double_quotes, text[1:-1])}"'
    if value is None or isinstance(value, (bool, int, float)):
        return repr(value)
    if isinstance(value, (list, tuple)):
        items = ", ".join(map(py, value))
        if isinstance(value, list):
            return f"[{items}]"
        return f"({items},)" if len(value) == 1 else f"({items})"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{py(k)}: {py(v)}" for k, v in value.items()) + "}"
    raise TypeError(f"a {type(value).__name__} can't be written as a literal")


def _for_double_quotes(found: re.Match[str]) -> str:
    return {'"': '\\"', "\\'": "'"}.get(found.group(), found.group())
