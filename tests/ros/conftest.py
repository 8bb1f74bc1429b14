"""What the ROS tests share: a DDS domain per test, interfaces built once, servers in processes of their own."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from patience import Ahead
from ros_bench import DATA, EXAMPLE, servers

import grip_bt.ros  # noqa: F401 - its settings come before any message package
from grip_bt.ros.environment import free_domain


@pytest.fixture(scope="module")
def own_domain() -> Iterator[int]:
    """Give a domain for servers that all tests of a module share."""
    with free_domain() as number:
        yield number


@pytest.fixture(scope="session")
def interface_cache() -> Path:
    """Return the folder in which interfaces are built once for all, projects among them."""
    from grip_bt.ros.interfaces import default_cache

    default_cache().mkdir(parents=True, exist_ok=True)
    return default_cache()


@pytest.fixture(scope="session")
def antipodal(interface_cache) -> Path:
    """Return the prefix of the example's interfaces, built and active in this process."""
    from grip_bt.ros.interfaces import build_interfaces
    from grip_bt.ros.interfaces.packages import activate

    (built,) = build_interfaces(EXAMPLE / "interfaces", interface_cache)
    activate(built.prefix)
    return built.prefix


@pytest.fixture
def bus(domain):
    """Return a bus on the test's domain, whose clients wait as long as a slow machine needs."""
    from patient_bus import PatientBus

    with PatientBus(f"test_{domain}", domain_id=domain) as made:
        yield made


@pytest.fixture
def ahead(monkeypatch) -> Ahead:
    """Return the time by which calls, goals and topics count their time-outs; a test may skip some of it."""
    clock = Ahead()
    for module in ("action", "base", "service", "topic"):
        monkeypatch.setattr(f"grip_bt.ros.client.{module}.time", clock)
    return clock


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
    from grip_bt.ros.interfaces.packages import activate

    (built,) = build_interfaces(DATA / "trial_interfaces", interface_cache)
    activate(built.prefix)
    return built.prefix


@pytest.fixture
def act(start_server, trial):
    """Return a function that starts `data/action_server.py`."""
    return lambda name="/work": start_server("action_server.py", name, overlays=[trial])


@pytest.fixture
def project(tmp_path, antipodal) -> Path:
    """Return a project with the example component and an odd one; its interfaces are built already."""
    folder = tmp_path / "project"
    components = folder / "components"
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(EXAMPLE, components / "antipodal_grasps", ignore=ignore)
    shutil.copytree(DATA / "odd_component", components / "odd", ignore=ignore)
    shutil.copytree(EXAMPLE / "interfaces", components / "odd" / "interfaces")
    return folder
