"""What the environment must hold to: headless OpenCV, a light import, no mixed ROS, nothing named by machine paths."""

import re
import shutil
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def _python(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600, cwd="/")
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_opencv_needs_no_libgl():
    maps = _python("import cv2; print(open('/proc/self/maps').read())")
    assert "cv2" in maps
    assert "libGL" not in maps


def test_only_the_headless_opencv_is_installed_here():
    assert version("opencv-python-headless")
    with pytest.raises(PackageNotFoundError):
        version("opencv-python")


def test_importing_grip_is_light():
    heavy = "{'rclpy', 'sapien', 'pinocchio', 'ompl', 'numpy', 'py_trees', 'fastapi', 'pydantic', 'cv2'}"
    loaded = _python(f"import sys, grip_bt; print(sorted({heavy} & set(sys.modules)))")
    assert loaded.strip() == "[]"


def test_listing_the_verbs_is_light():
    heavy = "{'rclpy', 'sapien', 'pinocchio', 'ompl', 'numpy', 'py_trees', 'fastapi', 'pydantic', 'yaml', 'cv2'}"
    loaded = f"print(sorted({heavy} & set(sys.modules)))"
    code = f"import sys; from grip_bt.cli.shell import make_parser; make_parser(); {loaded}"
    assert _python(code).strip() == "[]"


def test_public_names_exist():
    import grip_bt

    for name in grip_bt.__all__:
        assert getattr(grip_bt, name) is not None


def test_an_unknown_public_name_is_an_attribute_error():
    import grip_bt

    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        grip_bt.nonsense  # noqa: B018


def _tracked() -> list[Path]:
    listing = subprocess.run(["git", "ls-files"], capture_output=True, text=True, cwd=ROOT)
    if listing.returncode:
        pytest.skip("not a git checkout")
    return [ROOT / line for line in listing.stdout.splitlines()]


def test_lock_files_name_no_registry():
    locks = [p for p in _tracked() if p.name in ("lock.txt", "build.txt", "node.txt", "package-lock.json")]
    assert locks
    for lock in locks:
        host = r'"resolved"' if lock.suffix == ".json" else r"https?://|file:"
        assert not re.search(host, lock.read_text()), lock


def test_python_files_stay_small():
    long = {
        str(p.relative_to(ROOT)): n
        for p in _tracked()
        if p.suffix == ".py" and "golden" not in p.parts and p.exists() and (n := p.read_text().count("\n")) > 500
    }
    assert not long


@pytest.mark.parametrize(("system", "taken"), [("18.19.0", "wheel"), ("", "wheel"), ("20.19.0", "system")])
def test_node_comes_from_a_wheel_where_the_system_has_none_or_an_older_one(tmp_path, system, taken):
    """Stand-ins answer `node -e`, which asks whether they are too old, and else say who they are."""

    def program(file: Path, text: str) -> None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"#!/bin/sh\n{text}\n")
        file.chmod(0o755)

    for name in ("tools/with_node.sh", "requirements/node.txt"):
        (tmp_path / name).parent.mkdir()
        shutil.copy(ROOT / name, tmp_path / name)
    for name in ("node", "npm"):
        program(tmp_path / ".venv/node/bin" / name, "echo wheel")
        if system:
            program(tmp_path / "system" / name, f'[ "$1" = -e ] && exit {int(int(system[:2]) < 20)}; echo system')
    for name in ("bash", "dirname"):
        (tmp_path / "bin").mkdir(exist_ok=True)
        (tmp_path / "bin" / name).symlink_to(shutil.which(name))
    done = subprocess.run(
        ["bash", "tools/with_node.sh", "node"],
        cwd=tmp_path,
        env={"PATH": f"{tmp_path / 'system'}:{tmp_path / 'bin'}"},
        capture_output=True,
        text=True,
    )
    assert done.stdout.strip() == taken, done.stderr
