"""`grip doctor`: what this machine can do; each finding names the part, its state, and the command that fixes it."""

from __future__ import annotations

import argparse
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

from grip_bt.base.errors import libraries_of
from grip_bt.base.interpreter import python_command
from grip_bt.cli.terminal import tell
from grip_bt.ros.environment import environment

_APT = "apt-get install "
_CLONE = Path(__file__).parents[2].joinpath("Makefile").is_file()
_INSTALL = f"{'make demo (sets up .venv), or: ' if _CLONE else ''}pip install 'grip-bt[{{extra}}]'"


@dataclass(frozen=True)
class Finding:
    """One part of the set-up, the command that mends it, and whether the demo needs it."""

    part: str
    state: Literal["ok", "missing", "broken"]
    detail: str
    remedy: str = ""
    needed: bool = True


def _python() -> Finding:
    found = f"Python {platform.python_version()} ({sys.executable})"
    fits = (3, 11) <= sys.version_info[:2] <= (3, 13)
    return Finding("python", "ok" if fits else "broken", found, "use Python 3.11 to 3.13: make PYTHON=python3.12")


def _imports(part: str, extra: str, modules: dict[str, str]) -> Finding:
    """Import in a fresh interpreter, so that a library that crashes is a finding and not the end of us."""
    code = "import " + ", ".join(modules)
    done = subprocess.run(python_command("-W", "ignore", "-c", code), capture_output=True, text=True, timeout=120)
    if done.returncode == 0:
        return Finding(part, "ok", ", ".join(map(_version, modules.values())))
    reason = (done.stderr.strip().splitlines() or [f"ended with status {done.returncode}"])[-1]
    state: Literal["missing", "broken"] = "missing" if "ModuleNotFoundError" in reason else "broken"
    return Finding(part, state, reason, libraries_of(reason) or _INSTALL.format(extra=extra))


def _version(names: str) -> str:
    """Return the one of these distributions that is here, and its version."""
    for name in names.split():
        with suppress(PackageNotFoundError):
            return f"{name} {version(name)}"
    return f"{names} (not a package)"


def _rendering() -> Finding:
    missing = partial(Finding, "camera", "missing", remedy=_INSTALL.format(extra="sim"), needed=False)
    if find_spec("sapien") is None:
        return missing("no module 'sapien'")
    try:
        from grip_sim.cameras import render_support  # here: what it lacks is a finding, whatever it is
    except ImportError as error:
        return missing(str(error))
    return Finding("camera", "ok", render_support(), needed=False)


def _ros() -> Finding:
    found = environment()
    states: dict[str, Literal["ok", "broken"]] = {"wheels": "ok", "sourced": "ok", "mixed": "broken"}
    return Finding("ros", states.get(found.kind, "missing"), found.detail, found.remedy)


def _compiler() -> Finding:
    found = shutil.which("g++") and shutil.which("gcc")
    remedy = "sudo apt-get install g++ python3-dev"
    return Finding("compiler", "ok" if found else "missing", found or "no gcc/g++ to build ROS interfaces with", remedy)


_CORE = {name: name for name in ("py_trees", "pydantic", "networkx", "fastapi", "uvicorn", "numpy")}
_MOTION = {"pinocchio": "pin", "coal": "coal", "ompl.base": "ompl", "toppra": "toppra"}
_CHECKS: tuple[Callable[[], Finding], ...] = (
    _python,
    partial(_imports, "core", "all", _CORE),
    partial(_imports, "motion", "motion", _MOTION),
    partial(_imports, "simulator", "sim", {"sapien": "sapien", "cv2": "opencv-python opencv-python-headless"}),
    _rendering,
    _ros,
    _compiler,
)
_MARK = {"ok": "ok  ", "missing": "MISS", "broken": "FAIL"}


def add_doctor(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    fix = "run the commands that mend what is found: pip's, and as root the system's, else they are printed"
    parser.add_argument("--fix", action="store_true", help=fix)


def run_doctor(args: argparse.Namespace) -> int:
    """Print the findings; 1 when something that the demo needs is missing."""
    findings, lines = [check() for check in _CHECKS], []
    if args.fix and _mended(findings):
        findings = [check() for check in _CHECKS]
    for finding in findings:
        lines.append(f"{_MARK[finding.state]}  {finding.part:<12} {finding.detail}")
        if finding.state != "ok" and finding.remedy:
            lines.append(f"      {'':<12} fix: {finding.remedy}")
    tell(args.json, [asdict(f) for f in findings], lines)
    return int(any(f.state != "ok" and f.needed for f in findings))


def _mended(findings: list[Finding]) -> bool:
    """Run what mends findings, as far as it is one command of pip or apt; return whether there was something to run."""
    remedies = {finding.remedy for finding in findings if finding.state != "ok"}
    extras = sorted(set(re.findall(r"grip-bt\[(\w+)\]", " ".join(remedies))))
    packages = sorted({name for each in remedies if _APT in each for name in each.split(_APT)[1].split()})
    commands = [[sys.executable, "-m", "pip", "install", f"grip-bt[{','.join(extras)}]"]] if extras else []
    if packages and os.geteuid() == 0 and shutil.which("apt-get"):
        commands.append(["apt-get", "install", "-y", *packages])
    for command in commands:
        print(f"$ {shlex.join(command)}", file=sys.stderr, flush=True)
        subprocess.run(command, check=False, stdout=sys.stderr)  # what it didn't mend is found again
    return bool(commands)
