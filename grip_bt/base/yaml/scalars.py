"""Single values of YAML: what unquoted text means (YAML 1.2 core schema) and how a value is written.

Ours instead of a library's, so that reading, writing and quoting can't disagree: `on`, `no` and `1_000` are text.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping

WORDS: Mapping[str, object] = {
    "": None,
    "~": None,
    **dict.fromkeys(("null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
"""What the words of YAML mean without quotes; a key that is one of them isn't text."""
_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_SPECIAL_FLOAT = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_LONGEST_NUMBER = 64
_LARGEST_INTEGER = 2**63 - 1

_PLAIN_START = re.compile(r"[A-Za-z0-9_/.+(]|[^\W\d_]")
STRANGE = "\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff\ufffe\uffff"
"""For sets of regular expressions: beside control characters, what YAML forbids, or some take for a line's end."""
_UNPRINTABLE = re.compile(f"[\x00-\x08\x0b-\x1f{STRANGE}]")


def read_plain(text: str) -> object:
    """Return the value of an unquoted scalar: None, a bool, an int, a float or the text itself.

    Raises:
        ValueError: a number that doesn't fit 64 bits.
    """
    if text in WORDS:
        return WORDS[text]
    if _SPECIAL_FLOAT.fullmatch(text):
        return float(text.replace(".", "").lower())
    integer = _INTEGER.fullmatch(text)
    if not integer and not _FLOAT.fullmatch(text):
        return text
    if len(text) > _LONGEST_NUMBER:
        raise ValueError(f"a number of {len(text)} characters; quote it if it is text")
    if integer:
        value = int(text, 0) if text[:2] in ("0x", "0o") else int(text)
        if abs(value) > _LARGEST_INTEGER:
            raise ValueError(f"the whole number {text} doesn't fit 64 bits")
        return value
    number = float(text)
    if math.isinf(number):
        raise ValueError(f"the number {text} is larger than any float; infinity is written .inf")
    return number


def write_scalar(value: object, flow: bool) -> str:
    """Return a value on one line.

    Args:
        value: None, a bool, an int, a float or a text.
        flow: whether it stands within brackets or is a key, where more characters need quotes.

    Raises:
        TypeError: a task file can't hold such a value.
    """
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if math.isfinite(value):
            return repr(value)
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if not isinstance(value, str):
        raise TypeError(
            f"a task file can't hold {value!r}, a {type(value).__name__}; it holds text, numbers, "
            "true, false, null, lists and mappings of these"
        )
    return value if is_plain(value, flow) else quoted(value)


def is_plain(text: str, flow: bool) -> bool:
    """Tell whether a text can be written without quotes and be read back as the same text."""
    if not _PLAIN_START.match(text) or text[-1].isspace() or _UNPRINTABLE.search(text):
        return False
    if any(c in text for c in ("#\n\t,:?[]{}" if flow else "#\n\t")):
        return False
    if ": " in text or text.endswith(":") or text.startswith(("---", "...")):
        return False
    return text not in WORDS and not any(number.fullmatch(text) for number in (_INTEGER, _FLOAT, _SPECIAL_FLOAT))


def quoted(text: str) -> str:
    """Return a text in double quotes, with escapes that YAML and JSON share where possible."""
    return _UNPRINTABLE.sub(_escape, json.dumps(text, ensure_ascii=False))


def _escape(match: re.Match[str]) -> str:
    code = ord(match.group())
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
