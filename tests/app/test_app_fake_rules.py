"""Components that give their outcomes by rule can be tried without what they wrap."""

from __future__ import annotations

from grip_bt.app.runs.execute import run
from grip_bt.cli.__main__ import main


def test_a_task_with_a_ruled_component_runs_with_fakes(tmp_path):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    home = tmp_path / "components" / "counts"
    home.mkdir(parents=True)
    (home / "component.yaml").write_text(
        "name: counts\ninterface: std_srvs/srv/Trigger\nserver: /c\n"
        "outcomes: {some: success, none: not success}\nmeaning: {none: failure}\n"
    )
    assert main(["component", "add", str(home)]) == 0
    task = tmp_path / "t.yaml"
    task.write_text("grip: 1\nname: t\nroot: {node: component/counts}\n")
    result = run(task, robot="fake")
    assert (result.outcome, result.failure) == ("failure", None)
