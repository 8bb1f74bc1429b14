"""YAML text -> dicts, lists and scalars without places: the quick way in for texts that are right.

Tidy texts by `tidy`, others by libyaml. `quick_data` gives up on whatever is wrong, odd or absent here;
`syntax.parse` then reads the text slowly, and is the one that says what is wrong and where. So every refusal has one
wording, and a right text costs no places.
"""

from __future__ import annotations

from typing import Any

from grip_bt.base.yaml.scalars import read_plain
from grip_bt.base.yaml.syntax import LONGEST_KEY, MAX_CHARACTERS, MAX_DEPTH, MAX_VALUES, is_usual

from .tidy import tidy_data

_NO_KEY = object()


def quick_data(text: str) -> Any | None:
    """Return the data of a YAML text, or None when it takes `syntax.parse` to read it or to refuse it.

    What is returned equals `syntax.plain(syntax.parse(text))`.
    """
    if len(text) > MAX_CHARACTERS or not is_usual(text):
        return None
    try:
        tidy = tidy_data(text, _Meanings()) if _surely_few(text) else None
    except ValueError:
        return None
    return _by_libyaml(text) if tidy is None else tidy


def _surely_few(text: str) -> bool:
    """Tell whether a text can't have more values than a file may have, whatever its signs mean, nor endless lines."""
    items = text.count("[") + text.count(",") if "[" in text else 0
    return text.count("\n") < MAX_VALUES and 2 * text.count(":") + items < MAX_VALUES


def _by_libyaml(text: str) -> Any | None:
    try:
        from yaml import YAMLError
        from yaml.cyaml import CParser
    except ImportError:
        return None
    try:
        return _built(CParser(text))
    except (YAMLError, ValueError):
        return None


class _Meanings(dict[str, Any]):
    """What unquoted texts mean, each worked out once."""

    def __missing__(self, text: str) -> Any:
        self[text] = value = read_plain(text)
        return value


def _built(parser: Any) -> Any | None:
    """Return the only document of a parser's events; None when it uses what `syntax.parse` refuses."""
    from yaml import (
        AliasEvent,
        DocumentStartEvent,
        MappingStartEvent,
        ScalarEvent,
        SequenceStartEvent,
        StreamEndEvent,
    )

    root: list[Any] = []
    open_: list[tuple[Any, Any]] = []
    into: Any = root
    key: Any = None
    meanings = _Meanings()
    next_event = parser.get_event
    left = MAX_VALUES
    while left >= 0:
        event = next_event()
        kind = type(event)
        if kind is ScalarEvent:
            left -= 1
            if event.anchor or (event.tag and not (event.tag == "!" and event.style)):
                return None
            value = event.value if event.style else meanings[event.value]
            if type(into) is list:
                into.append(value)
            elif key is _NO_KEY:
                if type(value) is not str or len(value) > LONGEST_KEY or value in into:
                    return None
                key = value
            else:
                into[key] = value
                key = _NO_KEY
        elif kind is MappingStartEvent or kind is SequenceStartEvent:
            left -= 1
            if event.anchor or event.tag or key is _NO_KEY or len(open_) >= MAX_DEPTH:
                return None
            inner: Any = {} if kind is MappingStartEvent else []
            if type(into) is list:
                into.append(inner)
            else:
                into[key] = inner
            open_.append((into, key))
            into, key = inner, _NO_KEY if kind is MappingStartEvent else None
        elif kind is StreamEndEvent:
            return root[0] if len(root) == 1 and type(root[0]) is dict else None
        elif kind is AliasEvent or (kind is DocumentStartEvent and root):
            return None
        elif open_ and kind is not DocumentStartEvent:
            into, key = open_.pop()
            if type(into) is dict:
                key = _NO_KEY
    return None
