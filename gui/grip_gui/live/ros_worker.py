"""`python -m grip_gui.live.ros_worker`: answers the questions of `RosClientProcess` about the running ROS graph."""

from __future__ import annotations

import json
import os
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.failures import ExpectedError

WORKERS = 4
"""Questions at a time: one that waits for a message keeps no other waiting."""


def main() -> int:
    """Answer until the standard input ends."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what a library prints isn't an answer
    speaking = threading.Lock()

    def say(number: int, **said: object) -> None:
        with speaking:
            answers.write(json.dumps({"id": number, **said}) + "\n")
            answers.flush()

    looker: list[Any] = []
    opening = threading.Lock()

    def work(number: int, do: str, fields: dict[str, Any]) -> None:
        try:
            from grip_bt.ros.environment import require

            require()  # before anything of ROS is loaded: it says how to install what isn't there
            from grip_gui.live.inspector import RosInspector

            with opening:
                if not looker:
                    looker.append(RosInspector())
            say(number, value=getattr(looker[0], do)(**fields))
        except ExpectedError as error:
            say(number, error=error.message)
        except (GripError, ValueError, OSError, ImportError) as error:
            say(number, error=str(error))
        except Exception as error:  # noqa: BLE001 - one question that can't be answered ends no other
            say(number, error=f"{type(error).__name__}: {error}")

    with ThreadPoolExecutor(WORKERS, "look") as pool:
        for line in sys.stdin:
            asked = json.loads(line)
            pool.submit(work, asked.pop("id"), asked.pop("do"), asked)
    if looker:
        looker[0].close()
    return 0


if __name__ == "__main__":
    status = main()
    sys.stderr.flush()
    os._exit(status)  # what hangs in a thread of a library keeps nobody waiting
