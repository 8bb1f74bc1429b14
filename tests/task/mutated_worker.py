"""The child process of the mutated files: reads each as a task, and tells what came of it, one line of JSON a file.

Run as `python mutated_worker.py FOLDER FIRST COUNT`; FOLDER holds the files that are mutated. It ends at the first
file that raises anything but a `GripError`, that takes too long, or with which the process has grown too large.
"""

import json
import re
import resource
import signal
import sys
import time
import traceback
from pathlib import Path

from mutations import mutant

from grip_bt.base.errors import GripError
from grip_bt.task import dumps, fmt, loads, read
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate

HANG = 60.0
"""CPU time after which a file is given up; the slowest of 10,000 takes less than a second."""
MEGABYTES = 200
"""How large the whole process may become."""


class TooLongError(BaseException):
    """A file takes more than its time."""


def late(number, frame):
    raise TooLongError


def read_and_check(path, catalog):
    """Return what a file is, after making sure that a task that was read is one."""
    document = read(path)
    report = validate(document.task, catalog, document)
    return document, "invalid" if any(issue.severity == "error" for issue in report.issues) else "valid"


def told(path, catalog):
    begin = time.process_time()
    signal.setitimer(signal.ITIMER_VIRTUAL, HANG)
    try:
        document, result = read_and_check(path, catalog)
        words = ""
    except GripError as error:
        document, result, words = None, "refused", str(error)
    except TooLongError:
        return "too long", HANG, traceback.format_exc()[-2000:]
    except BaseException as error:  # noqa: BLE001 - that nothing else is raised is the question
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        return "broken", time.process_time() - begin, traceback.format_exc()[-2000:] or repr(error)
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    seconds = time.process_time() - begin
    if document is not None and len(document.text) < 100_000:
        assert loads(dumps(document.task)) == document.task or "nan" in document.text
        assert loads(fmt(document.text)) == document.task or "nan" in document.text
    return result, seconds, words


def peak():
    """Return the most memory [MB] that this program has had; `ru_maxrss` would count who started it too."""
    return int(re.search(r"VmHWM:\s*(\d+)", Path("/proc/self/status").read_text())[1]) / 1024


def main(folder, first, count):
    resource.setrlimit(resource.RLIMIT_AS, (2**30, 2**30))
    signal.signal(signal.SIGVTALRM, late)
    bases = [path.read_text() for path in sorted(folder.glob("*.base"))]
    catalog, path = Catalog.builtin(), folder / "mutant.yaml"
    validate(loads(bases[0]), catalog)
    for seed in range(first, first + count):
        kind, data = mutant(seed, bases)
        path.write_bytes(data)
        try:
            result, seconds, words = told(path, catalog)
        except BaseException:  # noqa: BLE001 - as above
            result, seconds, words = "broken", 0.0, traceback.format_exc()[-2000:]
        megabytes = peak()
        if megabytes > MEGABYTES:
            result = "too large"
        fact = {"seed": seed, "kind": kind, "result": result, "seconds": seconds, "megabytes": megabytes}
        sys.stdout.write(json.dumps({**fact, "size": len(data), "words": words[:2000]}) + "\n")
        sys.stdout.flush()
        if result == "too large":
            return  # it never shrinks again


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
