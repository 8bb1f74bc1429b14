from pathlib import Path

import pytest
from smach_runs import build_legacy, run_legacy, run_task

from grip_bt.formats.smach import import_file, import_with_execution, write_import
from grip_bt.formats.smach.recorded import record

DATA = Path(__file__).parent / "data"
EXECUTED = DATA / "executed"
ROOMS = {"CleanAll": {"rooms": ["bath", "attic"]}}


def verdicts(imported):
    return [c.verdict for c in imported.containers]


def texts(imported):
    return "\n".join(str(p) for c in imported.containers for p in c.issues)


@pytest.mark.parametrize(("name", "given"), [("computed_steps", {}), ("given_rooms", ROOMS)])
def test_what_only_a_run_knows_is_exact_when_it_is_run_and_does_the_same(name, given, tmp_path):
    file = tmp_path / f"{name}.py"
    file.write_text((EXECUTED / f"{name}.py").read_text().replace("json.loads(", "json.JSONDecoder().decode("))
    assert verdicts(import_file(file)) == ["failed"]
    imported = import_with_execution(file, given=given)
    assert verdicts(imported) == ["exact"]
    ((task, path),) = {n: tmp_path / f"{n}.yaml" for n in imported.tasks}.items()
    write_import(imported, {task: path}, tmp_path / "nodes")
    outcome, ends, _ = run_task(path)
    container = imported.containers[0]
    if given:
        from grip_bt.nodes.smach_source import load_legacy

        machine = load_legacy(file).CleanAll(**ROOMS["CleanAll"])
    else:
        machine = build_legacy(imported, task)
    assert (outcome, ends) == run_legacy(machine)
    assert len(ends) == len(container.added) >= 2


CONSTANTS = """
import json
import smach

class Speed(float):
    pass

class Set(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['ok'], input_keys=['speed'], output_keys=['seen'])
    def execute(self, userdata):
        userdata.seen = [userdata.speed, type(userdata.speed).__name__]
        return 'ok'

def build():
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        for name, speed, after in json.JSONDecoder().decode('[["A", 1.5, "B"], ["B", 4, "done"]]'):
            smach.StateMachine.add(name, Set(), {'ok': after}, constants={'speed': VALUE})
    return sm
"""


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_constants_that_only_a_run_knows_are_set_before_each_state(tmp_path, target):
    file = tmp_path / "legacy_constants.py"
    file.write_text(CONSTANTS.replace("VALUE", "speed"))
    imported = import_with_execution(file)
    assert verdicts(imported) == ["exact"]
    assert [added.constants for added in imported.containers[0].added.values()] == [{"speed": 1.5}, {"speed": 4}]
    path = tmp_path / "build.yaml"
    write_import(imported, {"build": path}, tmp_path / "nodes")
    outcome, ends, data = run_task(path, target)
    machine = build_legacy(imported, "build")
    assert [path for path, _ in ends[0::2]] == ["set speed of A", "set speed of B"]
    assert (outcome, ends[1::2]) == run_legacy(machine)
    assert data["seen"] == machine.userdata.seen == [4, "int"]


def test_a_constant_that_a_task_cannot_hold_is_told_and_not_flattened(tmp_path):
    file = tmp_path / "legacy_constants.py"
    file.write_text(CONSTANTS.replace("VALUE", "Speed(speed)"))
    imported = import_with_execution(file)
    assert verdicts(imported) == ["partial"]
    assert "the constant `speed` of 'A' is `Speed`, known only at run time: give its variable a value" in texts(
        imported
    )


def test_without_arguments_that_it_needs_a_machine_stays_failed_with_its_reason():
    imported = import_with_execution(EXECUTED / "given_rooms.py")
    assert verdicts(imported) == ["failed"]
    assert "room.upper()" in texts(imported)


def test_a_default_that_was_assumed_stays_where_the_run_had_no_parameters_either():
    imported = import_with_execution(EXECUTED / "vendor_base.py")
    assert "placeholders: rospy, tf2_ros, vendor_robot; what was read from the source is kept" in texts(imported)
    assert "assumes `'FIND_' + frame.upper()` = 'FIND_BASE_LINK'" in texts(imported)


def test_missing_packages_get_placeholders_and_the_machine_says_so(tmp_path):
    file = tmp_path / "vendor_base.py"
    file.write_text(
        (EXECUTED / "vendor_base.py")
        .read_text()
        .replace("'~frame', 'base_link'", "'~frame', 'base_link' if rospy else ''")
    )
    imported = import_with_execution(file)
    assert verdicts(imported) == ["partial"]
    assert "with placeholders for rospy, tf2_ros, vendor_robot" in texts(imported)
    (container,) = imported.containers
    assert list(container.added) == ["FIND_BASE_LINK", "TAKE"]
    assert container.added["TAKE"].state.outcomes == ["taken", "failed"]
    assert list(imported.tasks) == ["vendor_base"]


def test_recording_executes_no_machine_and_refuses_files_and_programs(tmp_path, monkeypatch):
    forbidden = tmp_path / "forbidden"
    monkeypatch.setenv("GRIP_TEST_FILE", str(forbidden))
    run = record(EXECUTED / "harmful.py", EXECUTED, {}, timeout=600)
    assert not forbidden.exists()
    assert [c.children[0].label for c in run.containers][:1] == ["STOP"]
    assert "a recorded machine is not executed" not in run.words


@pytest.mark.slow
def test_what_was_built_before_the_time_was_over_is_kept(tmp_path):
    file = tmp_path / "endless.py"
    file.write_text(
        "import smach\n"
        "def build():\n"
        "    sm = smach.StateMachine(['end'])\n"
        "    with sm:\n"
        "        smach.StateMachine.add('A', smach.State(['end']))\n"
        "    return sm\n"
        "def zz_hangs():\n"
        "    build()\n"
        "    while True: pass\n"
    )
    run = record(file, tmp_path, {}, timeout=12)
    assert "stopped after 12 s" in run.words
    assert run.containers[0].children[0].label == "A"


def test_a_run_that_builds_other_states_than_the_text_is_noted(tmp_path):
    file = tmp_path / "sly.py"
    file.write_text(
        "import smach\n"
        "def build():\n"
        "    sm = smach.StateMachine(['end'])\n"
        "    with sm:\n"
        "        smach.StateMachine.add('A', smach.State(['end']))\n"
        "        exec(\"smach.StateMachine.add('B', smach.State(['end']))\")\n"
        "    return sm\n"
    )
    assert verdicts(import_file(file)) == ["exact"]
    imported = import_with_execution(file)
    assert "the run adds the states ['A', 'B'], the text seems to add ['A']" in texts(imported)


def test_nothing_runs_unless_it_is_asked_for(tmp_path):
    file = tmp_path / "loud.py"
    file.write_text(f"import smach\nopen({str(tmp_path / 'ran')!r}, 'w')\nsm = smach.StateMachine(['a'])\n")
    import_file(file)
    assert not (tmp_path / "ran").exists()


def test_a_file_without_smach_is_not_run(tmp_path):
    file = tmp_path / "other.py"
    file.write_text("raise SystemExit\n")
    assert import_with_execution(file).containers == []


def test_the_record_is_json_on_stdout_whatever_the_module_prints():
    run = record(EXECUTED / "harmful.py", EXECUTED, {}, timeout=600)
    assert run.containers
    assert "nonsense" in run.words
