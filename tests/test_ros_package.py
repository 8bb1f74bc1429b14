"""The repository and a project are ROS packages: said in two files alike, installed whole, built by colcon."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from test_packaging import PACKAGES, PROJECT, ROOT

from grip_bt.app.project.folder import make_project, ros_files
from grip_bt.app.runs.execute import run

OTHER_KEYS = {"pyyaml": "python3-yaml", "py_trees": "py_trees"}
OPERATORS = {"version_gte": ">=", "version_lt": "<"}


def test_the_manifest_says_what_pyproject_says() -> None:
    manifest = ElementTree.parse(ROOT / "package.xml").getroot()
    said = {key: manifest.findtext(key) for key in ("name", "version", "description", "license")}
    assert said == {key: PROJECT[key] for key in said} | {"name": PROJECT["name"].replace("-", "_")}
    assert manifest.findtext("export/build_type") == "ament_python"
    needed = {}
    for line in PROJECT["dependencies"]:
        name, bounds = re.fullmatch(r"([\w.-]+?)((?:[<>]=?[\d.]+,?)*)", line).groups()
        key = OTHER_KEYS.get(name, f"python3-{name.replace('_', '-')}")
        needed[key] = set(bounds.split(","))
    listed = {
        part.text: {f"{OPERATORS[key]}{value}" for key, value in part.attrib.items()}
        for part in manifest.iterfind("exec_depend")
    }
    assert listed == needed


def installed(package: Path, work: Path) -> Path:
    """Install a package by the command that colcon gives, without colcon; return the prefix."""
    prefix, build = work / "install", work / "build"
    build.mkdir(parents=True)
    command = [sys.executable, "setup.py", "egg_info", "--egg-base", os.path.relpath(build, package)]
    command += ["build", "--build-base", str(build), "install", f"--prefix={prefix}", "--record", str(build / "log")]
    command += [f"--install-scripts={prefix}/lib/{ElementTree.parse(package / 'package.xml').findtext('name')}"]
    command += ["--single-version-externally-managed"]
    around = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    made = subprocess.run(command, cwd=package, env=around, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    return prefix


def marker(prefix: Path, name: str) -> Path:
    return prefix / "share" / "ament_index" / "resource_index" / "packages" / name


def test_the_repository_is_installed_whole(tmp_path: Path) -> None:
    prefix = installed(ROOT, tmp_path)
    (site,) = prefix.glob("lib/python3*/site-packages")
    tracked = subprocess.run(["git", "ls-files", *PACKAGES], capture_output=True, text=True, cwd=ROOT)
    if tracked.returncode:
        pytest.skip("not a git checkout")
    for line in filter(lambda line: (ROOT / line).is_file(), tracked.stdout.splitlines()):
        home = next(folder for folder in PACKAGES if line.startswith(f"{folder}/"))
        assert (site / (PACKAGES[home] + line.removeprefix(home))).read_bytes() == (ROOT / line).read_bytes()
    assert os.access(prefix / "lib" / "grip_bt" / "grip", os.X_OK)
    assert marker(prefix, "grip_bt").is_file()
    assert (prefix / "share" / "grip_bt" / "package.xml").is_file()


def test_a_project_is_installed_with_its_files_and_runs_from_there(tmp_path: Path) -> None:
    lab = tmp_path / "lab"
    make_project(lab, ros_files(lab))
    own = ["grip.yaml", "package.xml", "tasks/first.yaml", "tasks/take.yaml", "worlds/bench.yaml"]
    wanted = [*own, "launch/robot.launch.py", "nodes/deep/er/grip.py"]
    for file in (
        *wanted[len(own) :],
        "nodes/__pycache__/grip.pyc",
        "components/.hidden/file",
        "tasks/.grip/runs",
        "notes.txt",
    ):
        (lab / file).parent.mkdir(parents=True, exist_ok=True)
        (lab / file).write_text("")
    prefix = installed(lab, tmp_path / "work")
    share = prefix / "share" / "lab"
    assert sorted(str(f.relative_to(share)) for f in share.rglob("*") if f.is_file()) == sorted(wanted)
    assert marker(prefix, "lab").is_file()
    assert run(share / "tasks" / "first.yaml", robot="fake").status == "success"


@pytest.mark.slow
@pytest.mark.parametrize("how", [[], ["--symlink-install"]], ids=["copied", "linked"])
def test_colcon_builds_both_and_the_installed_grip_runs_the_installed_project(tmp_path: Path, how: list[str]) -> None:
    """With a `colcon` on the path: `make packaging` brings one."""
    colcon = shutil.which("colcon")
    if colcon is None:
        pytest.skip("colcon isn't installed; `make packaging` runs this with it")
    source = tmp_path / "src"
    listing = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    for line in filter(lambda line: (ROOT / line).is_file(), listing.stdout.splitlines()):
        (source / "grip-bt" / line).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / line, source / "grip-bt" / line)
    make_project(source / "lab", ros_files(source / "lab"))
    built = subprocess.run([colcon, "build", *how], cwd=tmp_path, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    assert sorted(re.findall(r"Finished <<< (\w+)", built.stdout)) == ["grip_bt", "lab"]
    line = "source install/setup.bash && install/grip_bt/lib/grip_bt/grip run install/lab/share/lab/tasks/first.yaml"
    ran = subprocess.run(["bash", "-c", f"{line} --robot fake"], cwd=tmp_path, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout + ran.stderr
