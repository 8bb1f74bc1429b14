"""The tutorials: what each page has its reader type and save works in that order, and says what the page says.

A fence with a title is a file that the reader saves, one of `sh` what is typed (its last line fails where a comment
says so), one of `text` lines that are among what was said. One project goes through all pages, as a reader's does. Of a
page before that wasn't read, the files are saved, and commands are left out that only look at or run something.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TUTORIALS = ROOT / "docs" / "tutorials"
PAGES = ("first_grasp", "own_node", "own_world", "own_component", "smach", "campaign", "real_robot")
FENCE = re.compile(
    r"(?P<fails>^<!-- fails -->\n)?^```(?P<kind>\w+)(?P<said>[^\n]*)\n(?P<body>.*?)^```$", re.DOTALL | re.MULTILINE
)
MAKES = re.compile(r"^(cd|mkdir|grip (new|component new|import)|sed -i)\b")
"""Commands that change the project, on which later pages build."""


@dataclass(frozen=True)
class Fence:
    kind: str
    said: str
    body: str
    fails: bool = False

    @property
    def file(self) -> str:
        found = re.search(r'title="([^"]+)"', self.said)
        return found[1] if found else ""


def fences(page: str) -> Iterator[Fence]:
    text = (TUTORIALS / f"{page}.md").read_text(encoding="utf-8")
    return (Fence(found["kind"], found["said"], found["body"], bool(found["fails"])) for found in FENCE.finditer(text))


class Reader:
    """Somebody at a shell."""

    def __init__(self, folder: Path):
        folder.mkdir()
        self.folder, self._groups, self.pages = folder, list[int](), list[str]()
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        self._environment = {**os.environ, "PATH": path, "NO_COLOR": "1"}

    @contextmanager
    def at_work(self, domain: int) -> Iterator[None]:
        """Have a DDS domain, and end what was left in the background."""
        self._environment["ROS_DOMAIN_ID"] = str(domain)
        try:
            yield
        finally:
            for group in self._groups:
                with suppress(ProcessLookupError):
                    os.killpg(group, signal.SIGKILL)
            self._groups.clear()

    def saves(self, fence: Fence) -> None:
        file = self.folder / fence.file
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(fence.body, encoding="utf-8")

    def types(self, fence: Fence) -> str:
        """Return what was said; the commands worked, or their last one didn't where the page says that."""
        script = f"set -eu\n{fence.body}\npwd > {self.folder.parent}/where\n"
        shell = subprocess.Popen(
            ["bash", "-c", script],
            cwd=self.folder,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            process_group=0,
        )
        self._groups.append(shell.pid)
        said, _ = shell.communicate(timeout=600)
        assert (shell.returncode != 0) == fence.fails, f"{fence.body}\n{said}"
        if not shell.returncode:
            self.folder = Path((self.folder.parent / "where").read_text().strip())
        return said


@pytest.fixture(scope="module")
def student(tmp_path_factory) -> Reader:
    return Reader(tmp_path_factory.mktemp("course") / "work")


@pytest.mark.ros
@pytest.mark.sim
@pytest.mark.parametrize("page", PAGES)
def test_a_reader_who_types_it_sees_what_it_says(page, student, domain):
    with student.at_work(domain):
        for before in PAGES[: PAGES.index(page)]:
            if before not in student.pages:
                skims(student, before)
        reads(student, page)


def skims(reader: Reader, page: str) -> None:
    """Do what a page makes, and nothing else."""
    reader.pages.append(page)
    for fence in fences(page):
        if fence.file:
            reader.saves(fence)
        elif fence.kind == "sh" and not fence.fails:
            kept = "\n".join(line for line in fence.body.splitlines() if MAKES.match(line))
            reader.types(Fence("sh", "", kept))


def reads(reader: Reader, page: str) -> None:
    """Type a page, and see what it says."""
    reader.pages.append(page)
    said = ""
    for fence in fences(page):
        if fence.file:
            reader.saves(fence)
        elif fence.kind == "sh":
            said = reader.types(fence)
        elif fence.kind == "text":
            for line in fence.body.splitlines():
                assert line.strip() in said, f"{line}\n--- isn't in what was said:\n{said}"


@pytest.mark.ros
@pytest.mark.sim
@pytest.mark.slow
@pytest.mark.parametrize(
    ("example", "page", "needs"),
    [
        ("explore", "exploring", "small_gicp"),
        ("unscrew", "unscrewing", "rclpy"),
        ("pipette", "pipetting", "sapien"),
    ],
)
def test_an_example_does_what_its_page_says(tmp_path, domain, example, page, needs):
    pytest.importorskip(needs)
    left_out = shutil.ignore_patterns(".grip", "__pycache__")
    reader = Reader(tmp_path / "work")
    reader.folder /= example
    shutil.copytree(ROOT / "examples" / example, reader.folder, ignore=left_out)
    with reader.at_work(domain):
        reads(reader, f"../{page}")


def test_every_page_is_one_of_the_course():
    assert {page.stem for page in TUTORIALS.glob("*.md")} == set(PAGES)
