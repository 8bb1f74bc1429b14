"""`grip check` tells which frames sensors and components name that nothing in a project's files has."""

from __future__ import annotations

import pytest

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.task import read_text
from grip_bt.task.validation import validate

PROJECT = "grip: 1\nrobot: panda_allegro\narms: {right: {hand: right_hand}}\nhands: {right_hand: {}}\n"
TASK = "grip: 1\nname: demo\nroot: ROOT\n"
COMPONENT = """name: plan
interface: my_msgs/srv/Plan
server: /plan
outcomes: {done: "true"}
ports: {target: {type: Pose, frame: FRAME}}
"""
MANIFEST = "id: component/plan\ndoc: Plan.\nimplementation: none:None\n"
OVERHEAD = """sensors:
  overhead:
    topics: {cloud: {topic: /c, type: PointCloud}}
    mount: {frame: optical, on: panda_link8}
    given_in: FRAME
"""


@pytest.fixture
def frames_told(tmp_path):
    """Return a function that returns what is said of `given_in` of a sensor and of `frame` of a component's port."""
    folder = tmp_path / "components" / "plan"
    (folder / "node").mkdir(parents=True)
    (folder / "node" / "manifest.yaml").write_text(MANIFEST)

    def told(frame: str, project: str = PROJECT) -> tuple[list[str], list[str]]:
        (folder / "component.yaml").write_text(COMPONENT.replace("FRAME", frame))
        project += OVERHEAD.replace("FRAME", frame)
        (tmp_path / "grip.yaml").write_text(project)
        return unfit("sensor/overhead"), unfit("component/plan")

    def unfit(node: str) -> list[str]:
        task = read_text(TASK.replace("ROOT", f"{{node: {node}}}")).task
        return [i.message for i in validate(task, project_catalog(tmp_path)).issues if i.code == "unfit-project"]

    return told


@pytest.mark.parametrize("frame", ["world", "panda_link8", "panda_link3", "optical"])
def test_a_frame_of_the_world_a_link_or_a_mount_is_known(frames_told, frame):
    assert frames_told(frame) == ([], [])


def test_a_frame_that_nothing_has_is_told_with_the_nearest_one(frames_told):
    (sensor,), (component,) = frames_told("panda_lnk8")
    assert sensor.startswith(
        "grip.yaml: sensors/overhead/given_in: unknown frame 'panda_lnk8'; did you mean 'panda_link8'?"
    )
    assert sensor.endswith("; only TF could provide it at run time")
    where = "components/plan/component.yaml: ports/target/frame"
    assert component.startswith(f"{where}: unknown frame 'panda_lnk8'; did you mean 'panda_link8'? (available: ")
    assert component.endswith("; TF is not used for a component's frames")


def test_a_frame_that_looks_like_none_of_the_project_is_tfs_to_sensors_and_unknown_to_components(frames_told):
    sensor, (component,) = frames_told("odom")
    assert sensor == []
    assert component.endswith("; TF is not used for a component's frames")


def test_nothing_is_said_of_frames_where_nobody_declares_any(frames_told):
    """Without a robot the mounts are known; of a robot that can't be read, nothing is."""
    sensor, component = frames_told("optcal", "grip: 1\n")
    assert "did you mean 'optical'?" in sensor[0]
    assert "did you mean 'optical'?" in component[0]
    assert frames_told("any", "grip: 1\nrobot: nowhere.urdf\n") == ([], [])


def test_a_frame_in_doubt_has_a_fix_in_words(tmp_path):
    (tmp_path / "grip.yaml").write_text(PROJECT + OVERHEAD.replace("FRAME", "panda_lnk8"))
    task = read_text(TASK.replace("ROOT", "{node: sensor/overhead}")).task
    issues = validate(task, project_catalog(tmp_path)).issues
    assert "write 'panda_link8'" in [issue.fix for issue in issues if issue.code == "unfit-project"]
