"""A template repository is a component that works: its tests pass, its node is up to date, its server answers."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from grip_bt.base.errors import GripError, ProjectExistsError
from grip_bt.codegen.scaffold import make_repository
from grip_bt.task.catalog.component_file import load_component


def grip(*words: object, cwd: Path, **env: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "grip_bt.cli", *map(str, words)]
    return subprocess.run(command, cwd=cwd, env=dict(os.environ, **env), capture_output=True, text=True, timeout=600)


@pytest.fixture
def project(tmp_path) -> Path:
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    return tmp_path


@pytest.mark.parametrize("language", ["python", "cpp"])
def test_nothing_of_the_template_is_left_in_the_files_and_the_node_is_up_to_date(project, language):
    done = grip("component", "new", "best_view_2", "--lang", language, cwd=project)
    assert done.returncode == 0, done.stderr
    folder = project / "components" / "best_view_2"
    for file in folder.rglob("*"):
        if file.is_file():
            assert "component_name" not in file.as_posix() + file.read_text()
            assert "ComponentName" not in file.as_posix() + file.read_text()
    assert load_component(folder).interface == "best_view_2_interfaces/srv/BestView2"
    assert grip("component", "add", "--check", folder, cwd=project).returncode == 0
    assert (folder / ".gitignore").is_file()
    packages = list(folder.rglob("package.xml"))
    assert len(packages) == (2 if language == "cpp" else 1)
    for file in packages:  # without it, colcon takes a package for one of ROS 1
        assert ElementTree.parse(file).findtext("export/build_type") == "ament_cmake"


def test_both_packages_of_the_cpp_repository_are_linked_into_the_workspace(tmp_path):
    """Colcon looks for no package below another one."""
    make_repository(tmp_path / "fast", "fast", "cpp")
    command = next(line for line in (tmp_path / "fast" / "README.md").read_text().splitlines() if "ln -s" in line)
    subprocess.run(
        ["bash", "-ec", command], cwd=tmp_path / "fast", env=os.environ | {"HOME": str(tmp_path)}, check=True
    )
    linked = {folder.name for folder in (tmp_path / "ws" / "src").iterdir() if (folder / "package.xml").is_file()}
    assert linked == {"fast", "fast_interfaces"}


def test_the_python_repository_passes_its_own_tests(tmp_path):
    make_repository(tmp_path / "mine", "mine", "python")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests"],
        cwd=tmp_path / "mine",
        capture_output=True,
        text=True,
    )
    assert "2 passed" in done.stdout, done.stdout + done.stderr


@pytest.mark.ros
@pytest.mark.slow
def test_the_python_component_is_built_started_and_answers(project, domain):
    assert grip("component", "new", "mine", cwd=project).returncode == 0
    done = grip("component", "test", "components/mine", cwd=project, ROS_DOMAIN_ID=str(domain))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "empty request: 'none' (1)" in done.stdout


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler")
def test_the_algorithm_of_the_cpp_repository_compiles_without_warnings_and_passes_its_test(tmp_path):
    folder = tmp_path / "mine"
    make_repository(folder, "mine", "cpp")
    sources = [folder / "src" / "algorithm.cpp", folder / "test" / "test_algorithm.cpp"]
    program = tmp_path / "test_algorithm"
    flags = ["-std=c++17", "-Wall", "-Wextra", "-Werror", f"-I{folder / 'include'}"]
    subprocess.run(["g++", *flags, *map(str, sources), "-o", str(program)], check=True)
    done = subprocess.run([str(program)], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "highest: ok, empty: ok\n")


def test_the_cpp_component_is_started_from_its_ros_package(tmp_path):
    make_repository(tmp_path / "mine", "mine", "cpp")
    start = load_component(tmp_path / "mine").start
    assert (start.package, start.executable) == ("mine", "server")


@pytest.mark.parametrize("name", ["Mine", "my-grasps", "2d", "a__b", "_a", "a_", "../a", ""])
def test_a_name_that_cannot_be_a_packages_is_refused(tmp_path, name):
    with pytest.raises(GripError, match="can't name a component"):
        make_repository(tmp_path / "x", name, "python")
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(("name", "other"), [("MyGrasps", "my_grasps"), ("my-grasps", "my_grasps"), ("2d", "d")])
def test_a_name_that_could_be_one_is_offered(tmp_path, name, other):
    with pytest.raises(GripError, match=f"a letter first, such as {other}$"):
        make_repository(tmp_path / "x", name, "python")


def test_a_folder_that_holds_something_is_left_as_it_is(tmp_path):
    (tmp_path / "mine.txt").write_text("precious")
    with pytest.raises(ProjectExistsError):
        make_repository(tmp_path, "mine", "python")
    assert [f.name for f in tmp_path.iterdir()] == ["mine.txt"]
