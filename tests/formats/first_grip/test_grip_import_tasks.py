"""Tasks of the first GRIP become tasks that do the same, with a report of what isn't as it was."""

import copy
import json
import os
import random
from contextlib import suppress
from pathlib import Path

import pytest
from original_files import PICK_AND_PLACE, write_configuration

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.execute import RunOptions, open_session
from grip_bt.app.runs.mocks import scripted
from grip_bt.base.errors import GripError
from grip_bt.base.message_store.files import read_joint_states, read_poses, read_trajectories
from grip_bt.base.yaml.tree import parse, to_data
from grip_bt.cli.__main__ import main
from grip_bt.compilers import to_machine, to_tree
from grip_bt.formats import first_grip
from grip_bt.formats.first_grip.tasks import text_task
from grip_bt.formats.imported import Request
from grip_bt.runtime import JournalReader, RunContext, Runner
from grip_bt.task import read
from grip_bt.task.catalog.component_file import load_component
from grip_bt.task.validation import validate

SEEDS = int(os.environ.get("GRIP_FUZZ_TASKS", "120"))


def errors_of(folder: Path, name: str) -> list[str]:
    document = read(folder / "tasks" / f"{name}.yaml")
    report = validate(document.task, project_catalog(folder), document)
    return [str(issue) for issue in report.issues if issue.severity == "error"]


def notes(imported) -> str:
    return "\n".join(map(str, imported.issues))


def test_a_project_comes_of_a_robot_and_a_task_and_passes_the_check(tmp_path, capsys):
    source, out = tmp_path / "old", tmp_path / "new"
    write_configuration(source)
    (source / "pick.yaml").write_text(PICK_AND_PLACE)
    assert main(["import", str(source), "--from", "grip", "-o", str(out)]) == 1
    told = capsys.readouterr().out
    assert "there is no node 'component/basic_grasping'" in told
    assert "run `grip component add components/basic_grasping` for its node" in told
    assert [e for e in errors_of(out, "pick") if "basic_grasping" not in e] == []
    task = read(out / "tasks" / "pick.yaml").task
    assert list(task.outcomes.items()) == [("Task success", "success"), ("Task failure", "failure")]
    assert task.root.children["reach"].children["move"].in_ == {"plan": "last_plan_panda_arm"}
    assert task.root.children["grasping"].on["outcome_0"] == "reach"
    project = find_project(out).file
    arm = project.arms["panda_arm"]
    assert (arm.planner, arm.speed, arm.attempts, arm.planning_time) == ("BiTRRT", 0.5, 2, 1.0)
    assert project.sensors["kinect2"].topics["pointcloud"].type == "PointCloud"
    assert project.sensors["kinect2"].mount.quaternion == pytest.approx((0.5**0.5, 0, 0.5**0.5, 0))
    component = load_component(out / "components" / "basic_grasping")
    assert (component.interface, component.server, len(component.outcomes)) == (
        "basic_grasping/srv/Grasp",
        "/grasping",
        2,
    )
    states = read_joint_states(out / "messages" / "joint_states.yaml")
    assert states["above_bin"].ordered(("panda_joint1", "panda_joint2")) == pytest.approx([1.49, 0.48], abs=0)
    assert list(read_poses(out / "messages" / "poses.yaml")[0]) == ["camera_pose"]
    assert list(read_trajectories(out / "messages" / "trajectories.yaml", states)) == ["there"]


def test_what_isnt_as_it_was_is_told(tmp_path):
    write_configuration(tmp_path)
    (tmp_path / "pick.yaml").write_text(PICK_AND_PLACE)
    told = notes(first_grip.read(Request(tmp_path)))
    for text in (
        "the plan that the commander kept to itself is a variable",
        "fails when the motion fails; the first GRIP ignored that",
        "pointcloud: PointCloud, by the names of alias and topic",
        "controllers of ROS 1: configure ros2_control; not imported",
        "run_node: false is respected",
    ):
        assert text in told


@pytest.mark.parametrize("also", ["pick.yaml", ""])
def test_files_of_the_first_editor_are_named_with_what_to_do_instead(also, tmp_path, capsys):
    (tmp_path / "robot.ini").write_text("[root]\n")
    assert main(["import", str(tmp_path / "robot.ini"), "--from", "grip", "-o", str(tmp_path / "out")]) == 1
    told = capsys.readouterr().err
    assert "robot.ini: files of the first GRIP's editor (.ini) aren't read: give the folder" in told
    assert [each.name for each in tmp_path.iterdir()] == ["robot.ini"]
    if also:
        (tmp_path / also).write_text(PICK_AND_PLACE)
        imported = first_grip.read(Request(tmp_path))
        assert "incomplete" in notes(imported)
        assert "or draw the task anew" in notes(imported)
        assert list(imported.tasks) == ["pick"]
    else:
        with pytest.raises(GripError, match=r"no task and no configuration(.|\n)*draw the task anew"):
            first_grip.read(Request(tmp_path))


def test_the_collision_scene_of_a_folder_comes_along(tmp_path):
    write_configuration(tmp_path)
    (tmp_path / "files" / "table.scene").write_text("(noname)+\n.\n")
    imported = first_grip.read(Request(tmp_path))
    assert imported.copies == {"table.scene": tmp_path / "files" / "table.scene"}
    assert "scene: table.scene" in imported.files["grip.yaml"]


COUNTING = """
name: count
outcomes: [Task success, Task failure]
states:
  - count: {source: counter, initial_value: 0, end_value: 4, output: n,
      transitions: {success: count, finished: Task success}}
"""


@pytest.mark.parametrize("compile_task", [to_tree, to_machine])
def test_a_counter_loop_counts_as_often_as_it_did(compile_task, tmp_path):
    (tmp_path / "count.yaml").write_text(COUNTING)
    task = first_grip.read(Request(tmp_path / "count.yaml")).tasks["count"]
    compiled = compile_task(task, project_catalog(tmp_path))
    result = Runner(compiled, RunContext()).run()
    assert (result.outcome, compiled.data[""].cells["n"].value) == ("Task success", 4)


def swinging(topic: object, timeout: object, group: str = "panda_arm") -> str:
    """Return a task that follows a stored trajectory and then waits."""
    ends = {"fail": "Task failure"}
    swing = {"source": "execute_trajectory", "group_name": group, "trajectory_name": "there"}
    wait = {"source": "wait_for", "topic_name": topic, "timeout": timeout}
    states = [
        {"swing": {**swing, "transitions": {"success": "wait", **ends}}},
        {"wait": {**wait, "transitions": {"success": "Task success", **ends}}},
    ]
    return json.dumps({"name": "swing", "outcomes": ["Task success", "Task failure"], "states": states})


GANTRY = "low: {x: 0.3, y: 0.1}\nhigh: {x: 0.3, y: -0.4}\n"
THERE = (
    "there:\n- {name: low, interpolate_time: 1, pause_time: 0.1}\n- {name: high, interpolate_time: 1, pause_time: 0}\n"
)


@pytest.mark.parametrize("topic", ["", "done"])
@pytest.mark.parametrize("target", ["bt", "sm"])
def test_a_stored_trajectory_is_followed_and_a_wait_waits(topic, target, tmp_path, capsys):
    source, out = tmp_path / "old", tmp_path / "new"
    write_configuration(source)
    (source / "files" / "joint_states.yaml").write_text(GANTRY)  # joints of the fake arm
    (source / "files" / "trajectories.yaml").write_text(THERE)
    (source / "swing.yaml").write_text(swinging(topic, "" if topic else 0.2))
    main(["import", str(source), "--from", "grip", "-o", str(out)])
    told = capsys.readouterr().out
    assert "has no equivalent" not in told
    assert "goes to where the trajectory begins" in told
    assert errors_of(out, "swing") == []
    project = out / "grip.yaml"
    project.write_text(project.read_text().replace("group: panda_arm", "group: arm") + "robot: panda_allegro\n")
    with open_session(out / "tasks" / "swing.yaml", RunOptions(robot="fake", target=target)) as session:
        result = session.runner.run()
        (arm,) = session.resources.arms.values()
        assert (result.outcome, result.failure) == ("Task success", None)
        assert arm.state().as_mapping()["y"] == pytest.approx(-0.4)


def test_waiting_is_for_a_topic_of_any_type_or_for_a_time(tmp_path):
    def waiting(topic, timeout):
        (tmp_path / "swing.yaml").write_text(swinging(topic, timeout))
        imported = first_grip.read(Request(tmp_path / "swing.yaml"))
        node = imported.tasks["swing"].root.children["wait"]
        return node.node, dict(node.with_), "wait: " in notes(imported)

    assert waiting("/done", None) == ("ros/wait_for_message", {"topic": "/done", "timeout": None}, False)
    assert waiting("done", 2.5) == ("ros/wait_for_message", {"topic": "/done", "timeout": 2.5}, False)
    assert waiting("", "3") == ("flow/wait", {"seconds": 3.0}, False)
    assert waiting("", "") == ("flow/wait", {"seconds": 0.0}, True)
    assert waiting("done", "soon") == ("ros/wait_for_message", {"topic": "/done", "timeout": None}, True)


def test_a_trajectory_of_a_hand_is_left_to_fill_in(tmp_path):
    (tmp_path / "swing.yaml").write_text(swinging("done", 1, group="gripper"))
    imported = first_grip.read(Request(tmp_path / "swing.yaml"))
    assert imported.tasks["swing"].root.children["swing"].node == "original/execute_trajectory"
    assert "ExecuteTrajectory has no equivalent" in notes(imported)


TEXT = """
name: pick_and_hold
outcomes: [success, fail]
states:
  - ConcurrentPlan:
      source: concurrent_state_machine
      outcomes: [success, fail]
      default_outcome: fail
      outcome_map: {success: {First: success, Second: success}}
      transitions: {success: Wait, fail: fail}
      states:
        - First: {source: plan, target_type: joint state, target_name: home, plan_name: to_pregrasp}
        - Second: {source: reinitialise_managers}
  - Wait:
      source: PressButton
      seconds: 3
      transitions: {success: success, failure: fail}
"""


def test_the_older_text_format_is_read_and_unknown_states_are_left_to_fill_in(tmp_path, capsys):
    (tmp_path / "hold.yaml").write_text(TEXT)
    out = tmp_path / "out"
    assert main(["import", str(tmp_path / "hold.yaml"), "--from", "grip", "-o", str(out)]) == 0
    assert "PressButton has no equivalent; write its class: nodes/original" in capsys.readouterr().out
    task = read(out / "tasks" / "pick_and_hold.yaml").task
    rules = task.root.children["ConcurrentPlan"].rules
    assert [(dict(rule.when), rule.then) for rule in rules] == [
        ({"First": ["success"], "Second": ["success"]}, "success"),
        ({}, "fail"),
    ]
    assert task.root.children["Wait"].with_ == {"seconds": 3}
    assert "class PressButton(Leaf):" in (out / "nodes" / "original" / "leaves.py").read_text()
    assert errors_of(out, "pick_and_hold") == []


PICK = """
name: fetch
source: framework_state_machine
outcomes: [failed, fetched_successfully]
params: {usual: [yes, no], of_arm: [commander]}
states:
  - Ready: {source: wait_for_signal, topic_name: go, outcomes: params.usual, transitions: {yes: Next, no: failed}}
  - Next:
      source: select
      params: {message_type: grasp, message_names: [first, second], output_keys: [selected_grasp]}
      transitions: {success: Think, fail: failed}
  - Think:
      source: concurrent_state_machine
      params: {done: [success, fail]}
      outcomes: [fail, success]
      default_outcome: fail
      outcome_map: {success: {Above: yes, Around: success, Away: success}}
      transitions: {success: Allow, fail: Next}
      states:
        - Above:
            source: plan
            params: {target_state_type: pregrasp, target_state_name: userdata, outcomes: params.usual}
            plan_name: above
            io_keys: [selected_grasp]
        - Around: {source: state_plan, target_state_type: grasp, target_state_name: userdata, plan_name: around,
            starting_state_type: pregrasp, starting_state_name: userdata, outcomes: params.done}
        - Away: {source: plan, target_state_type: joint_state, target_state_name: stability_pose, plan_name: away,
            starting_state_type: grasp, starting_state_name: userdata, outcomes: params.done, io_keys: params.of_arm}
  - Allow: {source: allow_manipulator_collisions, allow: True, collision_type: object-collision,
      transitions: {success: GoAbove, fail: failed}}
  - GoAbove: {source: move, plan_name: above, transitions: {success: Spread, fail: failed}}
  - Spread:
      {source: grasp, grasp_type: pregrasp, io_keys: [selected_grasp], transitions: {success: GoAround, fail: failed}}
  - GoAround: {source: move, plan_name: around, transitions: {success: Close, fail: failed}}
  - Close: {source: grasp, grasp_type: grasp, io_keys: [selected_grasp], transitions: {success: GoAway, fail: failed}}
  - GoAway: {source: move, plan_name: away, transitions: {success: fetched_successfully, fail: failed}}
"""
PICK = PICK.replace("yes", "'yes'").replace("no,", "'no',").replace("no]", "'no']").replace("no:", "'no':")


@pytest.fixture(scope="module")
def fetch(tmp_path_factory):
    """A project made of a task in the text form, and what the import printed of it."""
    folder = tmp_path_factory.mktemp("fetch")
    (folder / "fetch.yaml").write_text(PICK)
    assert main(["import", str(folder / "fetch.yaml"), "--from", "grip", "-o", str(folder / "out")]) == 0
    return folder / "out"


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_a_task_in_the_text_form_runs_on_fakes_as_it_comes_in(fetch, target):
    with open_session(fetch / "tasks" / "fetch.yaml", RunOptions(robot="fake", target=target)) as session:
        result = session.runner.run()
    assert (result.status, result.outcome, result.failure) == ("success", "fetched_successfully", None)


def test_names_stay_literals_and_outcomes_mean_what_they_say(fetch):
    task = read(fetch / "tasks" / "fetch.yaml").task
    assert dict(task.outcomes) == {"failed": "failure", "fetched_successfully": "success"}
    think = task.root.children["Think"]
    assert dict(think.outcomes) == {"fail": "failure"}
    assert dict(think.rules[0].when) == {"Above": ["success"], "Around": ["success"], "Away": ["success"]}
    assert dict(think.on) == {"fail": "Next", "success": "Allow", "failure": "failed"}
    assert think.children["Away"].children["get_stability_pose"].with_ == {
        "store": "joint_states",
        "name": "stability_pose",
    }
    assert task.data["selected_grasp"] == "Grasp"
    assert task.root.children["Ready"].on == {"success": "Next", "failure": "failed"}


def test_grasps_are_selected_one_after_the_other_until_there_is_none(fetch, tmp_path):
    options = RunOptions(robot="fake", mocks=scripted({"Think/Above": "failure"}), journal=tmp_path / "j.sqlite")
    with open_session(fetch / "tasks" / "fetch.yaml", options) as session:
        result = session.runner.run()
    with JournalReader(tmp_path / "j.sqlite") as reader:
        turns = reader.value(reader.variables(session.runner.run_id)["turns_of_Next"])
    assert (result.outcome, result.failure.code, turns) == ("failed", "no_item", 2)


def flat(**keys):
    """Return a task of one state that plans, whose parameters stand where the test wants them."""
    return {"name": "t", "outcomes": ["good", "bad"], "states": [{"P": {"source": "plan", **keys}}]}


WHAT = {"target_state_type": "joint_state", "target_state_name": "up", "plan_name": "p", "outcomes": ["good", "bad"]}


@pytest.mark.parametrize(
    "task",
    [
        flat(params=WHAT),
        flat(params=WHAT | {"plan_name": "other"}, plan_name="p"),
        flat(params={"kind": "joint_state"}, **WHAT | {"target_state_type": "params.kind"}),
        flat(**{key: f"params.{key}" for key in WHAT}) | {"params": WHAT},
        flat(**WHAT | {"outcomes": ["good", "params.last"]}) | {"params": {"last": "bad"}},
    ],
)
def test_parameters_are_handed_down_wherever_they_are_said(task):
    wanted, found = (text_task(each, "t.yaml").children["P"] for each in (flat(**WHAT), task))
    assert {key: found.slots[key] for key in wanted.slots} == wanted.slots
    assert (found.type, found.outcomes) == ("ComputePlan", ["good", "bad"])


def test_an_import_overwrites_only_what_it_made(tmp_path, capsys):
    (tmp_path / "hold.yaml").write_text(TEXT)
    out = tmp_path / "out"
    command = ["import", str(tmp_path / "hold.yaml"), "--from", "grip", "-o", str(out)]
    assert [main(command), main(command)] == [0, 0]
    (out / "tasks" / "pick_and_hold.yaml").write_text("mine")
    assert main(command) == 1
    assert "was not generated by an import and would be overwritten" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\n", "there is no task and no configuration of the first GRIP in it"),
        ("name: x\nstates: []\n", "`states` is a list of states and not empty"),
        ("name: x\nstates: [3]\n", "a state is `NAME: {source: ..., ...}`, not 3"),
        ("name: x\nstates: [{A: 3}]\n", "a mapping with `source` is expected"),
        ("name: x\nstates: [{A: {source: move}}, {A: {source: move}}]\n", "two states have this name"),
        ("name: x\nparams: {abc: 1}\nstates: [{A: {plan_name: params.abd}}]\n", "has 'abd'; did you mean 'abc'?"),
        (
            "states: [{A: {source: concurrent_state_machine, outcomes: [a], default_outcome: b, states: [{B: {}}]}}]\n",
            "it may end with 'b', which is none of its outcomes",
        ),
        ("name: x\ninitial: B\nstates: [{A: {source: move}}]\n", "it begins with 'B', which isn't there"),
    ],
)
def test_what_is_wrong_with_a_text_is_said(text, message, tmp_path):
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(GripError) as caught:
        first_grip.read(Request(tmp_path / "a.yaml"))
    assert message in str(caught.value)


def test_random_and_damaged_task_files_are_imported_or_refused_with_words(tmp_path):
    tasks = [to_data(parse(text, "t.yaml")) for text in (PICK_AND_PLACE, PICK)]
    whole = 0
    for seed in range(SEEDS):
        chance = random.Random(seed)
        task = copy.deepcopy(chance.choice(tasks))
        for _ in range(chance.randrange(3)):
            _damage(task, chance)
        data = bytearray(json.dumps(task), "utf-8")
        for _ in range(chance.choice((0, 0, 3))):
            data[chance.randrange(len(data))] = chance.randrange(256)
        file = tmp_path / f"t{seed}.yaml"
        file.write_bytes(bytes(data))
        with suppress(GripError):  # any other error fails the test
            whole += bool(first_grip.read(Request(file)).tasks)
    assert whole > SEEDS // 4


def _damage(found, chance: random.Random) -> None:
    """Do what a hand may do to a file: put something else, or nothing, anywhere."""
    places = []

    def walk(value):
        for key, each in value.items() if isinstance(value, dict) else enumerate(value):
            places.append((value, key))
            if isinstance(each, dict | list):
                walk(each)

    walk(found)
    holder, key = chance.choice(places)
    if chance.random() < 0.3:
        del holder[key]
    else:
        holder[key] = chance.choice([None, 3, -1.5, "", [], {}, [1, 2, 3], {"a": []}, [None], "params.x", "x" * 50])
