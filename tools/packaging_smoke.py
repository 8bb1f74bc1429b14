"""What each extra is tried by: a verb that needs it, in an empty folder, with nothing of the repository at hand."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from urllib.request import HTTPCookieProcessor, build_opener

Surroundings = Mapping[str, str]
SEEN = '''
import numpy as np
import grip_bt as grip
from grip_bt.base.values import PointCloud


@grip.leaf("table/look", outputs={"cloud": PointCloud})
def look():
    """See a block of 4 cm and one of 6 cm."""
    square = np.stack(np.meshgrid(*[np.linspace(0, 0.04, 12)] * 2, [0.1]), axis=-1).reshape(-1, 3)
    return PointCloud(np.vstack([square, square * [1.5, 1.5, 1] + [0.3, 0, 0]]).astype(np.float32))


@grip.leaf("table/count")
def count(number: int):
    """Take no other number than two."""
    assert number == 2, number
'''
TASK = """grip: 1
name: see
data: {cloud: PointCloud, number: int}
root:
  kind: sequence
  children:
    look: {node: table/look, out: {cloud: cloud}}
    boxes: {node: scene/update_from_cloud, in: {cloud: cloud}, out: {count: number}}
    count: {node: table/count, in: {number: number}}
"""


class SmokeError(Exception):
    """What an extra is for doesn't work."""


def _result(grip: Path, folder: Path, around: Surroundings, *words: str) -> dict[str, Any]:
    """Return the JSON object that a verb prints, whatever its libraries say beside it."""
    said = _told(grip, folder, around, *words, "--json")
    found = [line for line in said.splitlines() if line.startswith("{")]
    if len(found) != 1:
        raise SmokeError(f"grip {' '.join(words)} --json: {said}")
    return dict(json.loads(found[0]))


def _told(grip: Path, folder: Path, around: Surroundings, *words: str, status: int = 0) -> str:
    done = subprocess.run([grip, *words], cwd=folder, env=around, capture_output=True, text=True, timeout=900)
    if done.returncode != status or "Traceback" in done.stderr:
        raise SmokeError(f"grip {' '.join(words)}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def _documentation(grip: Path, folder: Path, around: Surroundings) -> None:
    """Have the documentation that came with the wheel served."""
    to = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    server = subprocess.Popen([grip, "docs", "running", "--no-browser"], cwd=folder, env=around, **to)  # type: ignore[call-overload]
    try:
        address = server.stdout.readline().strip()
        if b"Running a task" not in build_opener().open(address).read():
            raise SmokeError(f"grip docs: {address} isn't the page")
    finally:
        server.terminate()
        server.communicate()


def _page(grip: Path, folder: Path, around: Surroundings) -> None:
    """Have the editor show a task."""
    to = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    server = subprocess.Popen([grip, "edit", ".", "--no-browser"], cwd=folder, env=around, **to)  # type: ignore[call-overload]
    try:
        address = next(found for line in server.stdout if (found := re.search(r"http://\S+", line))).group()
        page = build_opener(HTTPCookieProcessor())
        page.open(address).read()
        shown = json.load(page.open(address.partition("?")[0] + "api/document?path=tasks/first.yaml"))
        if shown["path"] != "tasks/first.yaml":
            raise SmokeError(f"the page shows {shown}")
    finally:
        server.terminate()
        server.communicate()


def bare(grip: Path, work: Path, around: Surroundings) -> str:
    """Check, draw, convert, import, run over fakes, measure and edit; what needs more names its extra."""
    _told(grip, work, around, "new", "lab")
    lab, task = work / "lab", "tasks/first.yaml"
    (lab / "c.yaml").write_text(f"campaign: 1\ntask: {task}\nrobot: fake\nseeds: [0, 1]\n")
    (lab / "t.xml").write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="M"><Sequence><AlwaysSuccess/></Sequence></BehaviorTree></root>'
    )
    for words in (
        *(
            ("check", task),
            ("convert", task, "--to", "svg", "-o", "t.svg"),
            ("convert", task, "--to", "smach-py", "-o", "t.py"),
        ),
        *(("import", "--from", "btcpp", "t.xml"), ("run", task, "--robot", "fake"), ("bench", "c.yaml"), ("runs",)),
        *(("demo", "--robot", "fake"), ("world", "check", "table")),
    ):
        _told(grip, lab, around, *words)
    _page(grip, lab, around)
    _documentation(grip, lab, around)
    for words, extra in (
        (("demo",), "sim"),
        (("robot", "show", "panda"), "robots"),
        (("robot", "check", "shadow_left"), "motion"),
        (("messages", "list"), "ros"),
    ):
        if f"grip-bt[{extra}" not in _told(grip, lab, around, *words, status=1):
            raise SmokeError(f"grip {' '.join(words)} doesn't name the extra {extra!r}")
    return "checks, draws, converts, imports, runs over fakes, measures, edits"


def motion(grip: Path, work: Path, around: Surroundings) -> str:
    """Make the kinematic model of a hand that comes with us."""
    _told(grip, work, around, "robot", "check", "shadow_left")
    return "grip robot check shadow_left"


def robots(grip: Path, work: Path, around: Surroundings) -> str:
    """Read a ready-made arm."""
    if "panda" not in _told(grip, work, around, "robot", "show", "panda"):
        raise SmokeError("grip robot show panda doesn't speak of it")
    return "grip robot show panda"


def vision(grip: Path, work: Path, around: Surroundings) -> str:
    """Group what a cloud shows into boxes, over fakes."""
    _told(grip, work, around, "new", "lab")
    (work / "lab/nodes").mkdir(exist_ok=True)
    (work / "lab/nodes/seen.py").write_text(SEEN)
    (work / "lab/tasks/see.yaml").write_text(TASK)
    _told(grip, work / "lab", around, "run", "tasks/see.yaml", "--robot", "fake")
    return "scene/update_from_cloud finds two boxes"


def sim(grip: Path, work: Path, around: Surroundings) -> str:
    """Take something in simulation."""
    _told(grip, work, around, "new", "lab")
    end = _result(grip, work / "lab", around, "run", "tasks/take.yaml")
    if end["status"] != "success" or end["judged"] != {"held": True}:
        raise SmokeError(f"grip run tasks/take.yaml: {end}")
    return "grip run tasks/take.yaml: held"


def demo(grip: Path, work: Path, around: Surroundings) -> str:
    """Clear the table, with a component, which takes ROS; nothing may be written into the installation."""
    site = Path(
        _told(grip.with_name("python"), work, around, "-c", "import grip_bt; print(grip_bt.__path__[0])").strip()
    )
    before = {file for file in site.rglob("*") if file.suffix != ".pyc"}
    end = _result(grip, work, around, "demo")
    if new := {file for file in site.rglob("*") if file.suffix != ".pyc"} - before:
        raise SmokeError(f"grip demo wrote into the installation: {sorted(new)[:5]}")
    return f"grip demo: {end}"


def ros(grip: Path, work: Path, around: Surroundings) -> str:
    """Find ROS usable."""
    found = {part["part"]: part for part in json.loads(_doctor(grip, work, around))}
    if found["ros"]["state"] != "ok":
        raise SmokeError(f"grip doctor: {found['ros']}")
    return "grip doctor: ROS is ok"


def _doctor(grip: Path, work: Path, around: Surroundings) -> str:
    done = subprocess.run([grip, "doctor", "--json"], cwd=work, env=around, capture_output=True, text=True)
    return done.stdout


def recording(grip: Path, work: Path, around: Surroundings) -> str:
    """Export a run for Foxglove."""
    return _exported(grip, work, around, "mcap", b"\x89MCAP")


def rerun(grip: Path, work: Path, around: Surroundings) -> str:
    """Export a run for Rerun."""
    return _exported(grip, work, around, "rerun", b"RRF2")


def parquet(grip: Path, work: Path, around: Surroundings) -> str:
    """Write a campaign's results as Parquet."""
    _told(grip, work, around, "new", "lab")
    (work / "lab/c.yaml").write_text("campaign: 1\ntask: tasks/first.yaml\nrobot: fake\nseeds: [0, 1]\n")
    _told(grip, work / "lab", around, "bench", "c.yaml", "-o", "c.jsonl")
    _told(grip, work / "lab", around, "bench", "report", "c.jsonl", "-o", "c.parquet")
    if not (work / "lab/c.parquet").read_bytes().startswith(b"PAR1"):
        raise SmokeError("c.parquet isn't one")
    return "grip bench report -o c.parquet"


def cluster(grip: Path, work: Path, around: Surroundings) -> str:
    """Run a campaign on a cluster of one node."""
    _told(grip, work, around, "new", "lab")
    (work / "lab/c.yaml").write_text("campaign: 1\ntask: tasks/first.yaml\nrobot: fake\nseeds: [0, 1]\n")
    ray = grip.with_name("ray")
    alone = {**around, "RAY_USAGE_STATS_ENABLED": "0"}
    _told(ray, work, alone, "start", "--head", "--num-cpus", "1", "--include-dashboard", "false")
    try:
        _told(grip, work / "lab", alone, "bench", "c.yaml", "--cluster", "-o", "c.jsonl")
    finally:
        _told(ray, work, alone, "stop")
    return "grip bench --cluster"


def registration(grip: Path, work: Path, around: Surroundings) -> str:
    """Import what registers clouds."""
    subprocess.run([grip.with_name("python"), "-c", "import small_gicp"], cwd=work, env=around, check=True)
    return "import small_gicp"


def _exported(grip: Path, work: Path, around: Surroundings, to: str, begins: bytes) -> str:
    _told(grip, work, around, "new", "lab")
    _told(grip, work / "lab", around, "run", "tasks/first.yaml", "--robot", "fake")
    run = re.search(r"\b\d{8}-\d{6}-\w+", _told(grip, work / "lab", around, "runs"))
    if run is None:
        raise SmokeError("grip runs lists no run")
    _told(grip, work / "lab", around, "runs", run.group(), "--to", to, "-o", f"run.{to}")
    if not (work / f"lab/run.{to}").read_bytes().startswith(begins):
        raise SmokeError(f"run.{to} isn't one")
    return f"grip runs --to {to}"


def everything(grip: Path, work: Path, around: Surroundings) -> str:
    """Try all of them in one environment."""
    parts = (motion, robots, vision, sim, demo, ros, recording, registration)
    folders = [work / part.__name__ for part in parts]
    for folder in folders:
        folder.mkdir()
    return "; ".join(part(grip, folder, around) for part, folder in zip(parts, folders, strict=True))


SMOKES: Mapping[str, Callable[[Path, Path, Surroundings], str]] = {
    "": bare,
    **{
        part.__name__: part
        for part in (motion, robots, vision, sim, ros, recording, rerun, parquet, cluster, registration)
    },
    "all": everything,
}
"""Extra -> what tries it; returns what was seen."""
