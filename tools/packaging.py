"""Builds what pip gets, and tries every extra as a user would: a fresh environment, plain pip, a verb that needs it.

    python tools/packaging.py [--python 3.11] [--extra sim] [--out dist]

Into the folder go the wheel, the source distribution, `sizes.md`, `licences.md` and `sbom.json` (CycloneDX).
Environments are removed when they have been looked at; one is there at a time (up to 2 GB).
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

from packaging_smoke import SMOKES, SmokeError

ROOT = Path(__file__).resolve().parent.parent
PYTHONS = ("3.11", "3.12", "3.13")
ALLOWED = 250
"""Most that the installation without extras may take [MB]."""
LISTING = """
import importlib.metadata as found, json, os
rows = []
for one in found.distributions():
    size = sum(os.path.getsize(p) for f in one.files or () if os.path.isfile(p := one.locate_file(f)))
    said = one.metadata.get("License-Expression") or ""
    known = [c.split(" :: ")[-1] for c in one.metadata.get_all("Classifier") or () if c.startswith("License ::")]
    said = said or "; ".join(known)
    line = (one.metadata.get("License") or "").strip().splitlines()[:1]
    rows.append([one.metadata["Name"], one.version, said or "".join(line)[:60], size])
print(json.dumps(rows))
"""
Row = tuple[str, str, str, int]


def said(*command: str | Path, **more: object) -> str:
    """Run a command and return what it prints. Raises SmokeError: it fails; with its words."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **more)  # type: ignore[call-overload]
    if done.returncode:
        raise SmokeError(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return str(done.stdout)


def interpreter(version: str) -> str | None:
    """Return a Python of a version: the one on the path that works, or pyenv's."""
    places = [shutil.which(f"python{version}"), *sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python"))]
    for place in filter(None, places):
        found = subprocess.run([place, "-c", "import venv, ensurepip"], capture_output=True)
        if found.returncode == 0:
            return str(place)
    return None


def environment(python: str, folder: Path, *requirements: str | Path) -> Path:
    """Make an environment with plain pip, verified by `pip check`; return its Python."""
    said(python, "-m", "venv", folder)
    own = folder / "bin" / "python"
    said(own, "-m", "pip", "install", "-q", "--disable-pip-version-check", *requirements)
    said(own, "-m", "pip", "check", "--disable-pip-version-check")
    return own


def built(out: Path) -> tuple[Path, Path]:
    """Build the source distribution and, out of it, the wheel; `twine check` has nothing to say of them."""
    shutil.rmtree(out, ignore_errors=True)
    said("make", "docs", cwd=ROOT)
    said(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", out, cwd=ROOT)
    (source,) = out.glob("*.tar.gz")
    with tempfile.TemporaryDirectory() as place:
        shutil.unpack_archive(source, place, filter="data")
        (unpacked,) = Path(place).iterdir()
        said(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", out, cwd=unpacked)
    (wheel,) = out.glob("*.whl")
    with tempfile.TemporaryDirectory() as place:
        own = environment(sys.executable, Path(place) / "twine", "twine")
        print(said(own, "-m", "twine", "--no-color", "check", "--strict", source, wheel).strip())
    return wheel, source


def tried(wheel: Path, version: str, python: str, extra: str) -> list[Row]:
    """Install the wheel with an extra, try it, and return the distributions: name, version, licence, size [bytes].

    Raises:
        SmokeError: what the extra is for doesn't work.
    """
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="grip-packaging-") as place:
        own = environment(python, Path(place) / "env", f"{wheel}[{extra}]" if extra else wheel)
        rows: list[Row] = [tuple(row) for row in json.loads(said(own, "-c", LISTING, cwd=place))]
        installed = time.monotonic() - began
        work = Path(place) / "work"
        work.mkdir()
        (Path(place) / "home").mkdir()
        told = SMOKES[extra](own.with_name("grip"), work, _surroundings(Path(place) / "home"))
    size = megabytes(rows)
    print(
        f"{version} [{extra}]: {size} MB in {len(rows)} packages, {installed:.0f} s; pip check: ok; {told}", flush=True
    )
    if not extra and size > ALLOWED:
        raise SmokeError(f"an installation without extras takes {size} MB; {ALLOWED} are allowed")
    return rows


def built_by_colcon(version: str, python: str) -> None:
    """Have colcon build the repository and a project in an environment of its own, which pip fills."""
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    with tempfile.TemporaryDirectory(prefix="grip-colcon-") as place:
        own = environment(python, Path(place) / "env", "colcon-common-extensions", *needed)
        around = os.environ | {"PATH": f"{own.parent}{os.pathsep}{os.environ['PATH']}"}
        tests = (sys.executable, "-m", "pytest", "-q", "-m", "slow", "tests/test_ros_package.py")
        print(f"{version} colcon: {said(*tests, cwd=ROOT, env=around).strip().splitlines()[-1]}", flush=True)


def _surroundings(home: Path) -> dict[str, str]:
    """Return the variables of a user who has nothing else: no other Python's paths, no ROS, a home of his own."""
    kept = {name: value for name, value in os.environ.items() if name in ("PATH", "LANG", "TMPDIR")}
    return kept | {"HOME": str(home), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def megabytes(rows: list[Row]) -> int:
    """Return how much distributions take, without the tools that every environment begins with [MB]."""
    return round(sum(size for name, _, _, size in rows if name.lower() not in ("pip", "setuptools")) / 1e6)


def as_licences(rows: list[Row]) -> str:
    """Return a table of distributions and their licences, in Markdown."""
    lines = [f"| {name} | {version} | {licence or 'not stated'} |" for name, version, licence, _ in rows]
    return "\n".join(["| distribution | version | licence |", "|---|---|---|", *lines, ""])


def as_sbom(rows: list[Row]) -> str:
    """Return distributions as a bill of materials (CycloneDX 1.5)."""
    parts = [
        {
            "type": "library",
            "name": name,
            "version": version,
            "purl": f"pkg:pypi/{name.lower().replace('_', '-')}@{version}",
            "licenses": [{"license": {"name": licence}}] if licence else [],
        }
        for name, version, licence, _ in rows
    ]
    return json.dumps({"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1, "components": parts}, indent=1)


def main() -> int:
    """Build, install, try, and write the tables; 1 when something is wrong."""
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", action="append", help=f"default: {', '.join(PYTHONS)}")
    parser.add_argument("--extra", action="append", choices=("none", *declared), help="default: all, each by itself")
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="folder (default: dist)")
    args = parser.parse_args()
    extras = ["" if extra == "none" else extra for extra in args.extra or ("none", *declared)]
    wheel, _ = built(args.out)
    sizes, wrong, everything = ["| Python | extra | MB | packages |", "|---|---|---|---|"], 0, {}
    for version in args.python or PYTHONS:
        python = interpreter(version)
        if python is None:
            print(f"NOT RUN: Python {version} isn't installed")
            continue
        if not args.extra:
            try:
                built_by_colcon(version, python)
            except SmokeError as error:
                print(f"{version} colcon: WRONG: {error}", flush=True)
                wrong += 1
        for extra in extras:
            try:
                rows = sorted(tried(wheel, version, python, extra), key=lambda row: row[0].lower())
            except Exception as error:  # noqa: BLE001 - whatever it is, the others are tried
                print(f"{version} [{extra}]: WRONG: {type(error).__name__}: {error}", flush=True)
                wrong += 1
                continue
            everything |= {row[0].lower(): row for row in rows}
            sizes.append(f"| {version} | {extra or '(none)'} | {megabytes(rows)} | {len(rows)} |")
    found = [everything[name] for name in sorted(everything)]
    (args.out / "sizes.md").write_text("\n".join([*sizes, ""]))
    (args.out / "licences.md").write_text(as_licences(found))
    (args.out / "sbom.json").write_text(as_sbom(found))
    print("\n".join(sizes), f"tables: {args.out}/sizes.md, licences.md, sbom.json", sep="\n")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
