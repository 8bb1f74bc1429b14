"""`grip`: the command's beginning and end."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence

from . import STOPPED


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb and return its exit status."""
    gc.set_threshold(100_000)  # loading makes much and leaves no garbage: a tenth of what `grip check` takes
    if arguments is None and sys.argv[1:2] == ["check"]:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # NumPy's threads take longer to start than they would save
    try:
        from .shell import run_verb  # here, since Ctrl-C may come while this is being loaded

        return run_verb(arguments)
    except KeyboardInterrupt:
        print("grip: stopped", file=sys.stderr)
        return STOPPED
    finally:
        if arguments is None and "ompl" not in sys.modules:  # which looks for leaks at the end
            gc.freeze()  # the process ends, and looks at nothing of it again: as much


if __name__ == "__main__":
    sys.exit(main())
