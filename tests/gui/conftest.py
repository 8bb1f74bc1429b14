"""A project folder, and a page that is open on it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from played import BASE, TASK, PlayedLauncher, TestClient

from grip_gui.server import create_app


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give what drives a browser time on a machine that does much else: its scenarios end themselves sooner."""
    for item in items:
        if item.get_closest_marker("e2e") is not None:
            item.add_marker(pytest.mark.timeout(2400))


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A project folder with one task, and a file beside the folder that nobody may see."""
    folder = tmp_path / "project"
    (folder / "tasks").mkdir(parents=True)
    (folder / "grip.yaml").write_text("grip: 1\n")
    (folder / "tasks" / "tiny.yaml").write_text(TASK)
    (tmp_path / "secret.yaml").write_text("grip: 1\nname: secret\n")
    return folder


@pytest.fixture
def launcher() -> PlayedLauncher:
    return PlayedLauncher()


@pytest.fixture
def page(project: Path, launcher: PlayedLauncher) -> Iterator[TestClient]:
    """A browser that has opened the printed address."""
    app = create_app(project, launcher, token="right")
    with TestClient(app, base_url=BASE, headers={"origin": BASE}) as client:
        assert client.get("/?token=right").status_code == 200
        yield client
