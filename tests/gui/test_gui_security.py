"""Who gets in, and what is refused."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest
from played import BASE, SOCKET, TestClient
from starlette.websockets import WebSocketDisconnect

from grip_gui.security import LARGEST_BODY
from grip_gui.server import create_app


@pytest.fixture
def stranger(project: Path, launcher: object) -> TestClient:
    return TestClient(create_app(project, launcher, token="right"), base_url=BASE, headers={"origin": BASE})


@pytest.mark.parametrize("path", ["/", "/assets/index.js", "/nothing"])
def test_nothing_is_served_without_the_token(stranger: TestClient, path: str) -> None:
    answer = stranger.get(path)
    assert answer.status_code == 401
    assert "grip edit" in answer.json()["detail"]


@pytest.mark.parametrize("token", ["wrong", "", "righ", "right2", "r%C3%AFght"])
def test_a_wrong_token_is_refused(stranger: TestClient, token: str) -> None:
    assert stranger.get(f"/?token={token}").status_code == 401
    stranger.cookies.set("grip_token_8765", "wrong")
    assert stranger.get("/api/project").status_code == 401


def test_the_token_becomes_a_cookie_and_leaves_the_address(stranger: TestClient) -> None:
    answer = stranger.get("/?token=right&task=x", follow_redirects=False)
    assert answer.status_code == 303
    assert answer.headers["location"] == "/?task=x"
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=lax" in cookie
    assert stranger.get("/api/project").status_code == 200


def test_the_redirect_never_leaves_the_server(stranger: TestClient) -> None:
    answer = stranger.get("//evil.example/?token=right", follow_redirects=False)
    assert answer.headers["location"] == "/"


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:9999", "https://127.0.0.1:8765"])
def test_a_page_of_another_origin_gets_neither_heads_nor_the_socket(page: TestClient, origin: str) -> None:
    assert page.head("/api/project", headers={"origin": origin}).status_code == 403
    with pytest.raises(WebSocketDisconnect), page.websocket_connect(SOCKET, headers={"origin": origin}):
        pass


def test_a_change_without_an_origin_is_refused(project: Path, launcher: object) -> None:
    client = TestClient(create_app(project, launcher, token="right"), base_url=BASE)
    client.get("/?token=right")
    assert client.post("/api/session/control", json={"command": "stop"}).status_code == 403


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "0.0.0.0:8765", ""])
def test_another_host_name_is_refused(page: TestClient, host: str) -> None:
    assert page.get("/api/project", headers={"host": host}).status_code == 400


def test_the_socket_needs_the_token(stranger: TestClient, caplog: pytest.LogCaptureFixture) -> None:
    with (
        caplog.at_level(logging.WARNING),
        pytest.raises(WebSocketDisconnect),
        stranger.websocket_connect(SOCKET, headers={"origin": BASE}),
    ):
        pass
    assert "refused websocket" in caplog.text


@pytest.mark.parametrize(
    "path",
    [
        "../secret.yaml",
        "tasks/../../secret.yaml",
        "/etc/passwd",
        "/etc/x.yaml",
        "tasks/tiny.yaml/../../../secret.yaml",
        "..\\secret.yaml",
        "tasks/tiny.yaml\0.yaml",
        ".grip/runs.sqlite",
        ".hidden/x.yaml",
        "grip.txt",
        "",
        "tasks",
    ],
)
def test_no_path_leads_out_of_the_project(page: TestClient, path: str) -> None:
    answer = page.get("/api/document", params={"path": path})
    assert answer.status_code == 403
    assert page.post("/api/session", json={"task": path, "robot": "fake", "target": "bt", "seed": 0}).status_code == 403


def test_a_link_that_leads_out_is_not_followed(page: TestClient, project: Path) -> None:
    (project / "tasks" / "link.yaml").symlink_to(project.parent / "secret.yaml")
    assert page.get("/api/document", params={"path": "tasks/link.yaml"}).status_code == 403
    assert [task["path"] for task in page.get("/api/project").json()["tasks"]] == ["tasks/tiny.yaml"]


@pytest.mark.parametrize("path", ["/../secret.yaml", "/..%2f..%2fsecret.yaml", "/assets/..%2f..%2fapplication.py"])
def test_static_files_do_not_leave_their_folder(page: TestClient, path: str) -> None:
    assert page.get(path).status_code in {400, 404}


def test_a_large_body_is_refused_with_and_without_its_length(
    page: TestClient, caplog: pytest.LogCaptureFixture
) -> None:
    big = b'{"command": "' + b"x" * LARGEST_BODY + b'"}'
    assert page.post("/api/session/control", content=big).status_code == 413
    pieces = (big[i : i + 1000] for i in range(0, len(big), 1000))
    assert (
        page.post("/api/session/control", content=pieces, headers={"content-type": "application/json"}).status_code
        == 413
    )
    assert "refused" in caplog.text


@pytest.mark.parametrize("body", [{"command": "explode"}, {"command": "stop", "extra": 1}, {"command": None}])
def test_commands_that_are_none_are_refused(page: TestClient, body: dict[str, object]) -> None:
    assert page.post("/api/session/control", json=body).status_code == 422


@pytest.mark.parametrize(
    "change",
    [
        {"robot": "other"},
        {"seed": -1},
        {"seed": 2**31},
        {"pace": 0},
        {"pace": "nan"},
        {"target": "x"},
        {"task": "x" * 2000},
        {"shell": "rm"},
    ],
)
def test_run_options_outside_their_range_are_refused(page: TestClient, change: dict[str, object]) -> None:
    request = {"task": "tasks/tiny.yaml", "robot": "fake", "target": "bt", "seed": 0, **change}
    assert page.post("/api/session", json=request).status_code == 422


def test_pages_forbid_foreign_scripts_and_frames(page: TestClient) -> None:
    headers = page.get("/").headers
    assert "default-src 'self'" in headers["content-security-policy"]
    assert "frame-ancestors 'none'" in headers["content-security-policy"]
    assert headers["x-content-type-options"] == "nosniff"


OUTSIDE = [
    "../secret.yaml",
    "/etc/x.yaml",
    "tasks/../../secret.yaml",
    "..\\secret.yaml",
    ".grip/x.yaml",
    "tasks/a\0.yaml",
]


@pytest.mark.parametrize("path", OUTSIDE)
def test_no_route_takes_a_path_that_leads_out(page: TestClient, project: Path, path: str) -> None:
    before = sorted(project.parent.rglob("*.yaml"))
    requests: list[tuple[str, dict[str, object]]] = [
        ("/api/breakpoints", {"task": path, "breakpoints": []}),
        ("/api/setup/check", {"path": path, "text": ""}),
        ("/api/setup/change", {"path": path, "text": "", "key": ["a"], "value": 1}),
        ("/api/setup/save", {"path": path, "text": "a: 1", "over": True}),
        ("/api/setup/probe", {"path": path, "what": "generate"}),
    ]
    for route, request in requests:
        assert page.post(route, json=request).status_code == 403, route
    assert page.get("/api/setup/file", params={"path": path}).status_code == 403
    assert sorted(project.parent.rglob("*.yaml")) == before


@pytest.mark.parametrize("name", ["../a.py", "a/b.py", "a.sh", ".a.py", "a.py.sh", "", "a\0.py", "a.xml"])
def test_an_imported_file_lands_in_its_folder_or_nowhere(page: TestClient, project: Path, name: str) -> None:
    answer = page.post("/api/setup/import", json={"source": "smach", "name": name, "text": "x = 1"})
    assert answer.status_code in {400, 422}
    assert not (project / "legacy").exists()


def test_an_import_does_not_follow_a_link_out_of_the_project(page: TestClient, project: Path) -> None:
    outside = project.parent / "outside"
    outside.mkdir()
    (project / "legacy").symlink_to(outside)
    answer = page.post("/api/setup/import", json={"source": "smach", "name": "a.py", "text": "x = 1"})
    assert answer.status_code == 400
    assert not list(outside.iterdir())


def test_an_imported_file_is_read_and_never_executed(page: TestClient, project: Path) -> None:
    spoor = project.parent / "spoor"
    text = f"import smach\nopen({str(spoor)!r}, 'w').write('here')\nmachine = smach.StateMachine(outcomes=['a'])\n"
    assert page.post("/api/setup/import", json={"source": "smach", "name": "a.py", "text": text}).status_code == 200
    assert not spoor.exists()


@pytest.mark.parametrize(
    "text",
    [
        "a: &a [1]\nb: *a\n",
        "&a [*a]",
        "a: !!python/object/apply:os.system [true]",
        "[" * 5000,
        "a: 1\na: 2\n",
        "\x00",
        "a" * 100_000,
    ],
)
def test_hostile_texts_of_settings_are_told_as_faults(page: TestClient, text: str) -> None:
    answer = page.post("/api/setup/check", json={"path": "grip.yaml", "text": text})
    assert answer.status_code == 200
    assert answer.json()["problems"]
    change = {"path": "grip.yaml", "text": text, "key": ["doc"], "value": "x"}
    assert page.post("/api/setup/change", json=change).status_code in {200, 400}


def test_a_page_id_that_is_none_is_refused_at_the_socket(page: TestClient) -> None:
    with pytest.raises(WebSocketDisconnect), page.websocket_connect(SOCKET + "?page=" + "x" * 65):
        pass
