"""What pip gets: the wheel is whole, its extras are those that errors name, and it works where nobody may write."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from email import message_from_bytes
from pathlib import Path

import pytest

from grip_bt.base.errors import EXTRAS

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PACKAGES = {
    "grip_bt": "grip_bt",
    "gui/grip_gui": "grip_gui",
    "sim/grip_sim": "grip_sim",
    "examples": "grip_bt/_examples",
}
OTHER_NAMES = {"pyyaml": "yaml", "ruamel.yaml": "ruamel"}
WITH_THEM = {"annotated_types", "pydantic_core", "starlette"}
"""What pydantic and FastAPI are made of."""
NAMED_ELSEWHERE = {"launch", "pandas", "component_name_interfaces", "algorithm"}
"""ROS's launch, which only a sourced ROS has; data frames for those who have them; and words of templates."""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (file,) = folder.glob("*.whl")
    return file


def _imported() -> Iterator[tuple[str, Path]]:
    for folder in ("grip_bt", "gui/grip_gui", "sim/grip_sim"):
        for file in (ROOT / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    yield from ((alias.name.partition(".")[0], file) for alias in node.names)
                elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    yield node.module.partition(".")[0], file


def test_every_package_that_is_imported_is_required_or_an_extra_that_errors_name() -> None:
    required = {re.match(r"[\w.-]+", line).group() for line in PROJECT["dependencies"]}
    known = {OTHER_NAMES.get(name, name) for name in required} | WITH_THEM | NAMED_ELSEWHERE
    known |= set(" ".join(EXTRAS.values()).split()) | sys.stdlib_module_names | {"grip_bt", "grip_gui", "grip_sim"}
    assert {name: file for name, file in _imported() if name not in known} == {}


def test_extras_that_are_named_are_there() -> None:
    declared = set(PROJECT["optional-dependencies"])
    assert set(EXTRAS) <= declared
    for file in [*ROOT.glob("docs/*.md"), ROOT / "README.md", *(ROOT / "grip_bt").rglob("*.py")]:
        for named in re.findall(r"grip-bt\[([\w,]+)\]", file.read_text(encoding="utf-8")):
            assert set(named.split(",")) <= declared, file


def test_the_wheel_holds_all_that_is_in_the_repository_and_nothing_else(wheel: Path) -> None:
    listing = subprocess.run(["git", "ls-files", *PACKAGES], capture_output=True, text=True, cwd=ROOT)
    if listing.returncode:
        pytest.skip("not a git checkout")
    tracked = set()
    for line in listing.stdout.splitlines():
        home = next(folder for folder in PACKAGES if line.startswith(f"{folder}/"))
        if (ROOT / line).is_file():
            tracked.add(PACKAGES[home] + line.removeprefix(home))
    with zipfile.ZipFile(wheel) as archive:
        apart = (".dist-info/", "grip_bt/_docs/")  # the site is there where it was built
        names = {name for name in archive.namelist() if not any(part in name for part in apart)}
        metadata = message_from_bytes(archive.read(f"grip_bt-{PROJECT['version']}.dist-info/METADATA"))
        licences = [name for name in archive.namelist() if "/licenses/" in name]
    assert names == tracked
    assert set(metadata.get_all("Provides-Extra")) == set(PROJECT["optional-dependencies"])
    assert len(licences) == len(PROJECT["license-files"])


def _all_of(folder: Path) -> dict[Path, int]:
    return {file: file.stat().st_mtime_ns for file in folder.rglob("*")}


@pytest.mark.slow
def test_an_installation_that_nobody_may_write_to_works(wheel: Path, tmp_path: Path) -> None:
    """`demo`, `check` and `edit`; that nothing was written is seen from the files, since root may always write."""
    site, work = tmp_path / "site-packages", tmp_path / "work"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    work.mkdir()
    for file in [site, *site.rglob("*")]:
        file.chmod(0o555 if file.is_dir() else 0o444)
    before = _all_of(site)
    around = os.environ | {
        "PYTHONPATH": str(site),
        "PYTHONDONTWRITEBYTECODE": "1",
        "HOME": str(tmp_path / "home"),
        "XDG_DATA_HOME": "",
    }

    def grip(*words: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "grip_bt.cli", *words]
        return subprocess.Popen(
            command, cwd=work, env=around, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    try:
        demo = grip("demo", "--robot", "fake")
        told = demo.communicate()[0]
        assert demo.returncode == 0, told
        (task,) = (tmp_path / "home/.local/share/grip").glob("*/tasks/reactive_pick.yaml")
        check = grip("check", str(site / "grip_bt/_examples/tasks/reactive_pick.yaml"))
        assert check.communicate()[0].endswith("ok\n")
        edit = grip("edit", str(task), "--no-browser")
        assert any("http://" in line for line in iter(edit.stdout.readline, ""))
        edit.terminate()
        edit.communicate()
        assert _all_of(site) == before
    finally:
        for file in [site, *site.rglob("*")]:
            file.chmod(0o755)
