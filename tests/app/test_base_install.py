"""Without any extra, tasks are checked, drawn, converted, imported, edited in the page, run over fakes and measured."""

import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest
from patience import PATIENCE

from grip_bt.base.errors import EXTRAS

PARTS = [*" ".join(EXTRAS.values()).split(), "example_robot_data"]
HOOK = """import importlib.metadata
from importlib.machinery import PathFinder

find, distribution = PathFinder.find_spec, importlib.metadata.distribution


def present(name, path=None, target=None):
    return None if name.partition(".")[0] in {names!r} else find(name, path, target)


def installed(name):
    if name.replace("-", "_") in {names!r}:
        raise importlib.metadata.PackageNotFoundError(name)
    return distribution(name)


PathFinder.find_spec, importlib.metadata.distribution = present, installed
"""
TREE = """<root BTCPP_format="4" main_tree_to_execute="Main">
<BehaviorTree ID="Main"><Sequence><AlwaysSuccess/></Sequence></BehaviorTree></root>
"""
EXAMPLES = Path(__file__).parents[2] / "examples"
CAMPAIGN = "campaign: 1\ntask: tasks/first.yaml\nrobot: fake\nseeds: [0]\n"


@dataclass(frozen=True)
class Bare:
    """`grip` where no extra is installed, in a new project."""

    lab: Path
    environment: dict[str, str]

    def __call__(self, *words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "grip_bt.cli", *words]
        return subprocess.run(command, cwd=self.lab, env=self.environment, capture_output=True, text=True, timeout=600)


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Bare:
    folder = tmp_path_factory.mktemp("bare")
    (folder / "hook").mkdir()
    (folder / "hook/sitecustomize.py").write_text(HOOK.format(names=PARTS))
    (folder / "lab").mkdir()
    bare = Bare(folder / "lab", os.environ | {"PYTHONPATH": str(folder / "hook")})
    made = bare("new", ".")
    assert made.returncode == 0, made.stderr
    return bare


@pytest.mark.slow
def test_what_needs_no_robot_works_without_extras(bare):
    (bare.lab / "c.yaml").write_text(CAMPAIGN)
    (bare.lab / "tree.xml").write_text(TREE)
    for words in (
        ("check", "tasks/first.yaml"),
        ("convert", "tasks/first.yaml", "--to", "svg", "-o", "first.svg"),
        ("run", "tasks/first.yaml", "--robot", "fake"),
        ("run", "tasks/first.yaml", "--robot", "fake", "--as", "sm"),
        ("run", str(EXAMPLES / "tasks/reactive_pick.yaml"), "--robot", "fake"),
        ("convert", "tasks/first.yaml", "--to", "smach-py", "-o", "first.py"),
        ("import", "--from", "btcpp", "tree.xml"),
        ("bench", "c.yaml"),
        ("runs",),
    ):
        done = bare(*words)
        assert "Traceback" not in done.stderr, (words, done.stderr)
        assert done.returncode == 0, (words, done.stdout, done.stderr)
    told = bare("doctor").stdout
    assert all(part in told for part in ("motion", "simulator", "ros"))
    assert told.count("fix: ") >= 4


@pytest.mark.slow
def test_the_page_edits_a_task_without_extras(bare):
    words = [sys.executable, "-m", "grip_bt.cli", "edit", ".", "--no-browser"]
    to = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    server = subprocess.Popen(words, cwd=bare.lab, env=bare.environment, **to)
    path = "tasks/first.yaml"
    try:
        address = next(found for line in server.stdout if (found := re.search(r"http://\S+", line))).group()
        origin = address.partition("/?")[0]
        with httpx.Client(base_url=origin, headers={"Origin": origin}, follow_redirects=True, timeout=PATIENCE) as page:
            assert "<html" in page.get(address).text
            for question in ("/api/catalog", f"/api/document/forms?path={path}", "/api/setup/names", "/api/project"):
                assert page.get(question).is_success, page.get(question).text
            base = page.get("/api/document", params={"path": path}).json()["revision"]
            command = {"do": "set", "path": "/", "key": ["doc"], "value": "Without extras."}
            edited = page.post("/api/document/edit", json={"path": path, "base": base, "command": command})
            assert edited.is_success, edited.text
            assert page.post("/api/document/save", json={"path": path}).is_success
    finally:
        server.terminate()
        server.communicate()
    assert "Without extras." in (bare.lab / path).read_text()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "extra"),
    [
        (("run", "tasks/first.yaml", "--robot", "sim"), "grip-bt[sim]"),
        (("sim",), "grip-bt[sim,ros]"),
        (("robot", "show", "panda"), "grip-bt[robots]"),
        (("robot", "check", "shadow_left"), "grip-bt[motion]"),
        (("object", "list"), "grip-bt[sim]"),
        (("messages", "list"), "grip-bt[ros]"),
    ],
)
def test_what_needs_an_extra_names_it(bare, words, extra):
    done = bare(*words)
    assert done.returncode in (1, 2), done.stdout + done.stderr
    assert extra in done.stderr + done.stdout
    assert "Traceback" not in done.stderr
