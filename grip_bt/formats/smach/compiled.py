"""Legacy code, compiled once for all processes that record: what one has compiled the others load."""

from __future__ import annotations

import ast
import marshal
import os
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from types import CodeType

from grip_bt.nodes.smach_source import read_source

from . import tracked_code

folder: Path | None = None
"""Where the code is kept."""
is_keeping = False
"""Whether code is being written, which is all that may be written while legacy code runs."""


def code_of(file: Path) -> CodeType:
    """Return the code of a file, so that what it does with stand-ins is seen."""
    tracked_code.files.add(str(file))
    return _code_of(file, file.stat().st_mtime_ns)


@lru_cache(maxsize=4000)
def _code_of(file: Path, changed: int) -> CodeType:
    global is_keeping
    kept = (folder or file) / sha256(f"{file} {changed}".encode()).hexdigest()
    if kept.is_file():
        loaded: CodeType = marshal.loads(kept.read_bytes())
        return loaded
    made: CodeType = compile(tracked_code.tracked(ast.parse(read_source(file).text)), str(file), "exec")
    if folder is not None:
        is_keeping, part = True, kept.with_suffix(f".{os.getpid()}")
        try:
            part.write_bytes(marshal.dumps(made))
            os.replace(part, kept)
        finally:
            is_keeping = False
    return made
