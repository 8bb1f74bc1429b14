"""The flow charts on which the page's layout is measured: its unit tests read what the server says of these tasks."""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

from grip_gui.editing.views import view_of_text
from grip_gui.project import ProjectFolder

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "gui" / "frontend" / "test" / "flows.json"
DRAWN = ("path", "parent", "name", "kind", "label", "children", "outcomes", "initial", "on", "derived")


def test_the_measured_charts_are_those_of_the_tasks(tmp_path: Path) -> None:
    project = tmp_path / "project"
    shutil.copytree(ROOT / "examples", project, ignore=shutil.ignore_patterns(".grip"))
    shutil.copytree(
        ROOT / "tests" / "gui" / "flows", project, ignore=shutil.ignore_patterns("grip.yaml"), dirs_exist_ok=True
    )
    tasks = [path.stem for path in (ROOT / "tests" / "gui" / "flows" / "tasks").iterdir()]
    drawn = {}
    for task in sorted([*tasks, "fill_shelf", "reactive_pick"]):
        text = (project / "tasks" / f"{task}.yaml").read_text()
        view = view_of_text(ProjectFolder(project), text, f"tasks/{task}.yaml").model_dump(by_alias=True, mode="json")
        assert not [problem for problem in view["problems"] if problem["severity"] == "error"]
        drawn[task] = {
            "name": task,
            "outcomes": view["outcomes"],
            "nodes": [{key: node[key] for key in DRAWN} for node in view["nodes"]],
        }
    if os.environ.get("GRIP_WRITE_FLOWS"):
        lines = [f"{json.dumps(task)}: {json.dumps(view, sort_keys=True)}" for task, view in drawn.items()]
        KEPT.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    assert json.loads(KEPT.read_text(encoding="utf-8")) == drawn, "GRIP_WRITE_FLOWS=1 writes them anew"
