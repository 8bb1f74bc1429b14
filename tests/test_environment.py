"""What the environment must hold to: headless OpenCV, a light import, no mixed ROS, nothing named by machine paths."""

import re
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


def test_only_the_headless_opencv_is_installed():
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
    locks = [p for p in _tracked() if p.name in ("lock.txt", "build.txt", "package-lock.json")]
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
