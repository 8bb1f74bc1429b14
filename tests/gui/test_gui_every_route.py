"""Every route of the server, also those that come later: who and what is refused, told, and survived."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import pytest
from fastapi.routing import APIRoute
from played import BASE, PlayedLauncher, TestClient
from pydantic import BaseModel

from grip_gui.security import LARGEST_BODY, LARGEST_DOCUMENT
from grip_gui.server import create_app

SEED = 20
OUTSIDE = [
    "../secret.yaml",
    "/etc/x.yaml",
    "tasks/../../secret.yaml",
    "..\\secret.yaml",
    ".grip/runs.sqlite",
    "a\0.yaml",
]
STRANGE: list[Any] = ["", "x" * 5000, "\ud800", 0, -1, 2**70, 1e300, None, True, [], {}, [[]], {"a": 1}, [OUTSIDE[0]]]
HOSTILE = [*OUTSIDE, *STRANGE]
MALFORMED = [b"", b"{", b"[]", b"null", b"\xff", b"3", b'"a"', b'{"no such key": 1}', b"[" * 20_000, b'{"task": 1e999}']


def routes_of(method: str) -> list[APIRoute]:
    folder = Path(__file__).parents[2] / "examples"
    app = create_app(folder, token="right")
    return sorted(every_route(app.routes, method), key=lambda route: route.path)


def every_route(routes: Any, method: str) -> list[APIRoute]:
    """Return the routes with this method, also those of routers that are included as they are."""
    found = []
    for route in routes:
        if isinstance(route, APIRoute):
            found += [route] if method in route.methods else []
        else:
            inner = getattr(route, "original_router", None)
            found += every_route(inner.routes, method) if inner is not None else []
    return found


POSTS, GETS = routes_of("POST"), routes_of("GET")
EVERY = [("GET", route) for route in GETS] + [("POST", route) for route in POSTS]


def named(route: APIRoute) -> str:
    return route.path


def filled(route: APIRoute) -> str:
    return route.path.replace("{run}", "20261121-1").replace("{seq}", "1")


@pytest.fixture
def stranger(project: Path, launcher: PlayedLauncher) -> TestClient:
    return TestClient(create_app(project, launcher, token="right"), base_url=BASE, headers={"origin": BASE})


def test_the_routes_are_found() -> None:
    assert {"/api/session", "/api/document/edit", "/api/setup/save", "/api/live/put", "/api/lease"} <= set(
        map(named, POSTS)
    )
    assert {"/api/project", "/api/setup/file", "/api/live/motion", "/api/runs/{run}"} <= set(map(named, GETS))


def test_nobody_gets_in_without_the_token_and_it_is_logged(
    stranger: TestClient, caplog: pytest.LogCaptureFixture
) -> None:
    for method, route in EVERY:
        caplog.clear()
        assert stranger.request(method, filled(route)).status_code == 401, route.path
        assert f"refused http {filled(route)}" in caplog.text


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:9999", "https://127.0.0.1:8765"])
def test_no_other_origin_gets_in_and_it_is_logged(
    page: TestClient, origin: str, caplog: pytest.LogCaptureFixture
) -> None:
    for method, route in EVERY:
        caplog.clear()
        assert page.request(method, filled(route), headers={"origin": origin}).status_code == 403, route.path
        assert "comes from another origin" in caplog.text


@pytest.mark.parametrize("body", [*MALFORMED, None], ids=lambda body: repr(body)[:20])
def test_what_is_malformed_or_too_large_is_refused_logged_and_survived(
    page: TestClient, body: bytes | None, caplog: pytest.LogCaptureFixture
) -> None:
    for route in POSTS:
        caplog.clear()
        large = LARGEST_DOCUMENT if route.path.startswith(("/api/document/", "/api/setup/")) else LARGEST_BODY
        sent = b" " * (large + 1) if body is None else body
        answer = page.post(filled(route), content=sent, headers={"content-type": "application/json"})
        assert answer.status_code in ({413} if body is None else {400, 422}), route.path
        assert answer.json()["detail"]
        assert "refused" in caplog.text, route.path
    assert page.get("/api/project").status_code == 200


def test_hostile_values_of_every_field_are_survived_and_write_nothing_outside(page: TestClient, project: Path) -> None:
    rng = random.Random(SEED)
    outside = sorted(path for path in project.parent.iterdir() if path != project)
    secret = (project.parent / "secret.yaml").read_bytes()
    for route in POSTS:
        (model,) = (field.field_info.annotation for field in route.dependant.body_params)
        assert issubclass(model, BaseModel)
        for _ in range(25):
            keys = [key for key in model.model_fields if rng.random() < 0.9]
            body = json.dumps({key: rng.choice(HOSTILE) for key in keys})
            answer = page.post(filled(route), content=body, headers={"content-type": "application/json"})
            assert answer.status_code < 500, (route.path, body)
    assert page.get("/api/project").status_code == 200
    assert sorted(path for path in project.parent.iterdir() if path != project) == outside
    assert (project.parent / "secret.yaml").read_bytes() == secret


def test_hostile_questions_are_survived_and_nothing_outside_is_told(page: TestClient) -> None:
    for route in GETS:
        names = [param.name for param in route.dependant.query_params]
        for value in [*OUTSIDE, "x" * 5000, "", "-1", "1e999", "%00", "\u2603"] if names else []:
            answer = page.get(filled(route), params=dict.fromkeys(names, value))
            assert answer.status_code < 500, (route.path, value)
            assert "name: secret" not in answer.text
            if "path" in names:
                assert answer.status_code in {400, 403, 404, 422}, (route.path, value)
