"""Where a project's editor was served last: who starts it again finds the pages that are still open."""

from __future__ import annotations

import json
import logging
import os
import socket
from contextlib import suppress
from pathlib import Path
from secrets import token_urlsafe

from grip_bt.base.errors import GripError

log = logging.getLogger(__name__)
HOST = "127.0.0.1"


def listen(file: Path, port: int) -> tuple[socket.socket, str]:
    """Return a listening socket, and the token of the project: those that `file` keeps where they can be had.

    Args:
        file: readable for its owner alone; another one, or one that can't be read, counts for nothing.
        port: 0 takes the one from before where that is free, else any.

    Raises:
        GripError: the port is taken.
    """
    before, token = _read(file)
    listener = None
    if not port and before:
        with suppress(OSError):
            listener = socket.create_server((HOST, before))
    try:
        listener = listener or socket.create_server((HOST, port))
    except OSError as error:
        raise GripError(
            f"port {port} of {HOST} isn't free ({error.strerror}); leave --port out for a free one"
        ) from error
    token = token or token_urlsafe(24)
    _keep(file, {"port": listener.getsockname()[1], "token": token})
    return listener, token


def _read(file: Path) -> tuple[int, str]:
    """Return port and token; 0 and nothing where none are kept that only the owner can know."""
    with suppress(OSError, ValueError, TypeError, KeyError):
        state = file.lstat()
        if state.st_uid == os.getuid() and state.st_mode & 0o177777 == 0o100600:
            kept = json.loads(file.read_text(encoding="utf-8"))
            port, token = kept["port"], kept["token"]
            if type(port) is int and 0 < port < 65536 and type(token) is str and len(token) >= 32 and token.isascii():
                return port, token
    return 0, ""


def _keep(file: Path, address: dict[str, object]) -> None:
    """Write the address; that it can't be kept keeps nobody from editing."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        aside = file.with_name(f"{file.name}.{os.getpid()}")
        aside.unlink(missing_ok=True)
        with open(os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as out:
            json.dump(address, out)
        aside.replace(file)
    except OSError as error:
        log.warning("the editor's address isn't kept, so that open pages don't come back after a restart: %s", error)
