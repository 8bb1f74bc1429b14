"""Files of older formats: a text-preserving step for each version, from the file's own to the one that is read.

`grip: 1` is the first format that was published, so there is no step yet. Whoever changes the format raises
`FORMAT_VERSION` and adds the step from the version before; old files then go on being read as they are, and `grip fmt`
writes them in the new format.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from grip_bt.base.errors import DocumentError
from grip_bt.base.yaml.syntax import Mapping as Tree
from grip_bt.base.yaml.syntax import Scalar, Value

from .model import FORMAT_VERSION

Step = Callable[[str], str]
"""Text of one version -> text of the next one, comments and all that isn't about the change kept."""
STEPS: Mapping[int, Step] = {}
"""Version -> the step to the version after it."""


def version_of(tree: Value) -> int | None:
    """Return the version that a file says it has; None where it says none."""
    entry = tree.entries.get("grip") if isinstance(tree, Tree) else None
    value = entry.value.value if entry is not None and isinstance(entry.value, Scalar) else None
    return value if type(value) is int else None


def migrated(text: str, tree: Value, source: str = "", steps: Mapping[int, Step] | None = None) -> str:
    """Return a file's text in the format that is read; the same text where it is in that format or says none.

    Args:
        text: the file.
        tree: its syntax.
        source: the file's name, for messages.
        steps: version -> step; by default those of this module.

    Raises:
        DocumentError: it is of a newer format, or of an older one that is no longer read.
    """
    steps = STEPS if steps is None else steps
    version = version_of(tree)
    if version is None or version == FORMAT_VERSION or not isinstance(tree, Tree):
        return text
    entry = tree.entries["grip"]
    at = (source, entry.value.line, entry.value.column)
    if version > FORMAT_VERSION:
        known = f"this grip reads up to `grip: {FORMAT_VERSION}`"
        raise DocumentError(f"a file of the newer format {version}; {known}: update it, `pip install -U grip-bt`", *at)
    for number in range(version, FORMAT_VERSION):
        if number not in steps:
            oldest = min([*steps, FORMAT_VERSION])
            raise DocumentError(f"a file of the format {version}; the oldest that is read is `grip: {oldest}`", *at)
        text = steps[number](text)
    return text
