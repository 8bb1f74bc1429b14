"""What the ROS tests share: a DDS domain per test, interfaces built once, servers in processes of their own."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

import pytest
from server_process import serving

import grip_bt.ros  # noqa: F401 - its settings come before any message package
from grip_bt.app.domain import free_domain

EXAMPLE = Path(__file__).parents[2] / "examples" / "components" / "antipodal_grasps"
DATA = Path(__file__).parent / "data"


@pytest.fixture(scope="module")
def own_domain() -> Iterator[int]:
    """Give a domain for servers that all tests of a module share."""
    with free_domain() as number:
        yield number


@pytest.fixture(scope="session")
def interface_cache(tmp_path_factory) -> Path:
    """Return a folder in which interfaces are built once for all tests."""
    return tmp_path_factory.mktemp("interfaces")


@pytest.fixture(scope="session")
def antipodal(interface_cache) -> Path:
    """Return the prefix of the example's interfaces, built and active in this process."""
    from grip_bt.ros.interfaces import build_interfaces
    from grip_bt.ros.overlay import activate

    (built,) = build_interfaces(EXAMPLE / "interfaces", interface_cache)
    activate(built.prefix)
    return built.prefix


@pytest.fixture
def bus(domain):
    """Return a bus on the test's domain."""
    from grip_bt.ros.bus import Bus

    with Bus(f"test_{domain}", domain_id=domain) as made:
        yield made


@contextmanager
def servers(domain: int):
    """Give a function that starts a program of `data/` in a process that isn't ours to watch, and waits for its word.

    It takes the file's name, arguments, and prefixes with further packages; all are killed at the end.
    """
    with ExitStack() as stack:

        def start(file: str, *arguments: str, overlays=()) -> subprocess.Popen:
            return stack.enter_context(serving(DATA / file, *arguments, domain=domain, overlays=overlays))

        yield start


@pytest.fixture
def start_server(domain):
    """Return a function that starts a program of `data/`; see `servers`."""
    with servers(domain) as start:
        yield start


@pytest.fixture
def serve(start_server):
    """Return a function that starts `data/servers.py`."""
    return partial(start_server, "servers.py")


@pytest.fixture(scope="session")
def trial(interface_cache) -> Path:
    """Return the prefix of `trial_interfaces`, built and active in this process."""
    from grip_bt.ros.interfaces import build_interfaces
    from grip_bt.ros.overlay import activate

    (built,) = build_interfaces(DATA / "trial_interfaces", interface_cache)
    activate(built.prefix)
    return built.prefix


@pytest.fixture
def act(start_server, trial):
    """Return a function that starts `data/action_server.py`."""
    return lambda name="/work": start_server("action_server.py", name, overlays=[trial])


@pytest.fixture
def project(tmp_path, interface_cache, antipodal) -> Path:
    """Return a project with the example component and an odd one; its interfaces are built already."""
    folder = tmp_path / "project"
    (folder / ".grip").mkdir(parents=True)
    (folder / ".grip" / "interfaces").symlink_to(interface_cache)
    components = folder / "components"
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(EXAMPLE, components / "antipodal_grasps", ignore=ignore)
    shutil.copytree(DATA / "odd_component", components / "odd", ignore=ignore)
    shutil.copytree(EXAMPLE / "interfaces", components / "odd" / "interfaces")
    return folder


def ended(operation, within: float = 20.0):
    """Return the result of an operation, or raise its error; it must end `within` [s]."""
    assert operation.wait(within), "the operation hangs"
    return operation.result()


def session_of(pid: int) -> list[int]:
    """Return the processes of the session that `pid` leads, zombies included."""
    found = []
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                fields = (folder / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            if int(fields[3]) == pid:
                found.append(int(folder.name))
    return found


def gone(pid: int, within: float = 5.0) -> bool:
    """Tell whether no process of a session is left `within` [s]."""
    deadline = time.monotonic() + within
    while time.monotonic() < deadline:
        if not session_of(pid):
            return True
        time.sleep(0.02)
    return False


def kill(pid: int) -> None:
    os.kill(pid, signal.SIGKILL)
