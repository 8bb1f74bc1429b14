"""Who is let in, over every mixture of host, origin, token, way and length: the gate alone, without an application."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from starlette.exceptions import HTTPException

from grip_gui.security import HEADERS, LARGEST_BODY, LARGEST_DOCUMENT, Gate, cookie_name

PORT = 8765
HERE = ("127.0.0.1:8765", "localhost:8765", "[::1]:8765")
ELSEWHERE = ("evil.example:8765", "127.0.0.1.evil.example:8765", "0.0.0.0:8765", "")
SAFE = ("GET", "HEAD")


class Inside:
    """The guarded application: it reads the whole body and answers."""

    def __init__(self) -> None:
        self.entered = 0

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        self.entered += 1
        if scope["type"] != "http":
            return
        while (await receive()).get("more_body"):
            pass
        await send({"type": "http.response.start", "status": 200, "headers": [(b"own", b"1")]})
        await send({"type": "http.response.body", "body": b""})


def asked(
    kind: str = "http",
    method: str = "GET",
    path: str = "/api/project",
    query: str = "",
    body: tuple[int, ...] = (),
    **headers: str | None,
) -> tuple[int, list[dict[str, Any]], int]:
    """Ask the gate; return the status (200 for a socket let in), what was sent, and how often it was passed.

    Args:
        kind: `http`, `websocket` or `lifespan`.
        method: of a request.
        path: of the address.
        query: of the address.
        body: lengths of its pieces.
        headers: by name; None for a header that isn't there.
    """
    raw = [(k.replace("_", "-").encode(), v.encode("latin-1")) for k, v in headers.items() if v is not None]
    scope = {"type": kind, "method": method, "path": path, "query_string": query.encode(), "headers": raw}
    scope |= {"server": ("127.0.0.1", PORT), "client": ("127.0.0.1", 5)}
    pieces, sent, inside = list(body), [], Inside()

    async def receive() -> dict[str, Any]:
        piece = b"x" * (pieces.pop(0) if pieces else 0)
        return {
            "type": "http.request" if kind == "http" else "websocket.connect",
            "body": piece,
            "more_body": bool(pieces),
        }

    async def send(message: dict[str, Any]) -> None:
        sent.append(message)

    try:
        asyncio.run(Gate(inside, "right")(scope, receive, send))
    except HTTPException as refused:
        return refused.status_code, sent, 0
    status = sent[0].get("status", 0) if sent else 200
    return status, sent, inside.entered


def cookie(token: str) -> str:
    return f"{cookie_name({'server': ('', PORT)})}={token}"


@settings(max_examples=400, deadline=None)
@given(
    kind=st.sampled_from(["http", "http", "websocket"]),
    method=st.sampled_from(["GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS"]),
    host=st.sampled_from([*HERE, *HERE, *ELSEWHERE]),
    origin=st.sampled_from(["same", "same", None, "http://evil.example", "null", "http://127.0.0.1:9999", "https"]),
    given_token=st.sampled_from(["", "", "token=right", "token=wrong", "a=1&token=right", "token=wrong&token=right"]),
    kept=st.sampled_from(
        [None, cookie("right"), cookie("right"), cookie("wrong"), "grip_token_1=right", "other=right"]
    ),
    length=st.sampled_from([None, "0", "17", str(LARGEST_BODY), str(LARGEST_BODY + 1), "-1", "many", str(10**12)]),
)
def test_who_is_let_in(
    kind: str, method: str, host: str, origin: str | None, given_token: str, kept: str | None, length: str | None
) -> None:
    said = {"same": f"http://{host}", "https": f"https://{host}"}.get(origin or "", origin)
    changes = kind == "websocket" or method not in SAFE
    if host not in HERE:
        expected = 400
    elif (said is not None or changes) and origin != "same":
        expected = 403
    elif kind == "http" and "token=right" in given_token:
        expected = 303
    elif kept != cookie("right"):
        expected = 401
    elif length is not None and not (length.isdigit() and int(length) <= LARGEST_BODY):
        expected = 413
    else:
        expected = 200
    status, sent, entered = asked(
        kind, method, query=given_token, host=host, origin=said, cookie=kept, content_length=length
    )
    assert entered == (expected == 200)
    if kind == "http":
        assert status == expected
    elif expected != 200:
        assert [(m["type"], m["code"]) for m in sent] == [("websocket.close", 1008)]


def test_the_token_leaves_the_address_and_is_kept_where_no_script_reads_it() -> None:
    status, sent, _ = asked(path="//evil.example/x", query="a=1&token=right&b=2", host=HERE[0])
    headers = {key: value.decode() for key, value in sent[0]["headers"]}
    assert (status, headers[b"location"]) == (303, "/?a=1&b=2")
    assert headers[b"set-cookie"].startswith(cookie("right"))
    assert {"httponly", "samesite=lax", "path=/"} <= set(headers[b"set-cookie"].lower().split("; "))
    assert asked(query="token=right", host=HERE[0])[1][0]["headers"][-1] is not None


def test_what_is_let_in_is_answered_with_the_headers_of_every_page() -> None:
    _, sent, _ = asked(host=HERE[0], cookie=cookie("right"))
    headers = dict(sent[0]["headers"])
    assert headers[b"own"] == b"1"
    assert {key.lower().encode(): value.encode() for key, value in HEADERS.items()}.items() <= headers.items()


@pytest.mark.parametrize(
    ("path", "most"),
    [("/api/session", LARGEST_BODY), ("/api/document/text", LARGEST_DOCUMENT), ("/api/setup/check", LARGEST_DOCUMENT)],
)
def test_a_body_without_its_length_is_counted_as_it_comes(path: str, most: int) -> None:
    me = {"host": HERE[0], "origin": f"http://{HERE[0]}", "cookie": cookie("right")}
    assert asked(method="POST", path=path, body=(most - 1, 1), **me)[0] == 200
    assert asked(method="POST", path=path, body=(most - 1, 2), **me)[0] == 413
    assert asked(method="POST", path=path, content_length=str(most), **me)[0] == 200
    assert asked(method="POST", path=path, content_length=str(most + 1), **me)[0] == 413


def test_starting_and_stopping_the_server_needs_nobody() -> None:
    assert asked("lifespan")[2] == 1


def test_a_cookie_that_is_none_is_no_token() -> None:
    for broken in ("a b=\x01;", f"{cookie('right')[:-1]}", "=;;=", "grip_token_8765"):
        assert asked(host=HERE[0], cookie=broken)[0] == 401
