"""Who may talk to the server, and where: pages that were opened with its token, on this machine, from this origin."""

from __future__ import annotations

import json
import logging
import os
import socket
from contextlib import suppress
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from secrets import compare_digest, token_urlsafe
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse, RedirectResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from grip_bt.base.errors import GripError

log = logging.getLogger(__name__)

LARGEST_BODY = 64 * 1024  # longest body of a request [bytes]
LARGEST_DOCUMENT = 16 * 1024 * 1024
"""Longest body of a request about a document: a task's longest text, with room for escapes [bytes]."""
LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; "
        "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
}


class Gate:
    """ASGI middleware that lets nobody in without the token.

    The token comes once, in the opened URL, and becomes a cookie; then the URL is cleaned. The name of the cookie
    carries the port, since browsers share the cookies of a host between its ports. Requests that change something, and
    the socket, must come from this origin, which a foreign page can't forge; the host must be a loopback name, which
    stops DNS rebinding.
    """

    def __init__(self, app: ASGIApp, token: str):
        self._app, self._token = app, token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Guard one connection."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            status, why = refusal
            log.warning("refused %s %s from %s: %s", scope["type"], scope["path"], scope.get("client"), why)
            if scope["type"] == "websocket":
                await receive()
                await send({"type": "websocket.close", "code": 1008, "reason": why})
            else:
                await JSONResponse({"detail": why}, status_code=status)(scope, receive, send)
        elif scope["type"] == "http" and (given := self._given(scope)) is not None:
            # Relative to the root whatever the path was: a redirect never leaves this server.
            welcome = RedirectResponse("/" + (f"?{given}" if given else ""), status_code=303)
            welcome.set_cookie(cookie_name(scope), self._token, httponly=True, samesite="lax", path="/")
            await welcome(scope, receive, send)
        else:
            await self._pass(scope, receive, send)

    def _refusal(self, scope: Scope, headers: Headers) -> tuple[int, str] | None:
        host = urlsplit(f"//{headers.get('host', '')}")
        if host.hostname not in LOOPBACK:
            return 400, "the host isn't this machine"
        changes = scope["type"] == "websocket" or scope["method"] not in {"GET", "HEAD"}
        origin = headers.get("origin")
        if (changes or origin) and origin != f"http://{host.netloc}":
            return 403, "the request comes from another origin"
        if scope["type"] == "http" and self._given(scope) is not None:
            return None
        if not self._knows_token(scope, headers):
            return 401, "open the address that `grip edit` printed: it carries the token of this start"
        length = headers.get("content-length", "0")
        if not length.isdigit() or int(length) > _limit(scope):
            return 413, f"a request may have {_limit(scope)} bytes"
        return None

    def _given(self, scope: Scope) -> str | None:
        """Return the query without the token when the URL carries the right one, else None."""
        query = parse_qsl(scope["query_string"].decode("latin-1"))
        tokens = [value for key, value in query if key == "token"]
        if not any(_equal(token, self._token) for token in tokens):
            return None
        return urlencode([(key, value) for key, value in query if key != "token"])

    def _knows_token(self, scope: Scope, headers: Headers) -> bool:
        try:
            jar = SimpleCookie(headers.get("cookie", ""))
        except CookieError:
            return False
        name = cookie_name(scope)
        return name in jar and _equal(jar[name].value, self._token)

    async def _pass(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a connection in, with a limit on what it sends and headers on what it gets."""
        seen, most = 0, _limit(scope)

        async def limited() -> Message:
            nonlocal seen
            message = await receive()
            seen += len(message.get("body", b"")) if message["type"] == "http.request" else 0
            if seen > most:
                log.warning("refused a body of more than %d bytes from %s", most, scope.get("client"))
                raise HTTPException(413, f"a request may have {most} bytes")
            return message

        async def dressed(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(HEADERS)
            await send(message)

        await self._app(scope, limited, dressed)


def _limit(scope: Scope) -> int:
    return LARGEST_DOCUMENT if str(scope["path"]).startswith(("/api/document/", "/api/setup/")) else LARGEST_BODY


def cookie_name(scope: Any) -> str:
    """Return the name of the cookie that holds the token of the server at this port."""
    return f"grip_token_{(scope.get('server') or ('', 0))[1]}"


def _equal(given: str, token: str) -> bool:
    return compare_digest(given.encode("utf-8", "replace"), token.encode())


# --- the address ------------------------------------------------------------------------------------------------------

HOST = "127.0.0.1"


def listen(file: Path, port: int) -> tuple[socket.socket, str]:
    """Return a listening socket, and the token of the project: those from before, so that open pages come back.

    Args:
        file: where they are kept, readable for its owner alone; one that isn't, or can't be read, counts for nothing.
        port: 0 takes the one from before where that is free, else any.
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
