"""What a recording process sees of the construction of machines, and what it refuses."""

import sys
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

import pytest
from smach_runs import GO, build_legacy, record, recorded, run_legacy, run_task, texts, verdicts, write_recorded

from grip_bt.cli.__main__ import main
from grip_bt.formats.smach import import_file
from grip_bt.formats.smach.found import Run, Told
from grip_bt.formats.smach.recorder import answered
from grip_bt.nodes.smach_source import load_legacy

DATA = Path(__file__).parent / "data"
EXECUTED = DATA / "executed"
ROOMS = {"CleanAll": {"rooms": ["bath", "attic"]}}
BUILD = """
def build():
    sm = smach.StateMachine([OUTCOMES])
    with sm:
        smach.StateMachine.add('A', Go(), {EDGES})
    return sm
"""


@pytest.mark.parametrize(("name", "given"), [("computed_steps", {}), ("given_rooms", ROOMS)])
def test_what_only_a_run_knows_is_exact_and_does_the_same(name, given, tmp_path):
    file = tmp_path / f"{name}.py"
    file.write_text((EXECUTED / f"{name}.py").read_text())
    imported, paths = write_recorded(file, tmp_path, given=given)
    assert verdicts(imported) == ["exact"]
    ((task, path),) = paths.items()
    outcome, ends, _ = run_task(path)
    machine = load_legacy(file).CleanAll(**ROOMS["CleanAll"]) if given else build_legacy(imported, task)
    assert (outcome, ends) == run_legacy(machine)
    assert len(ends) == len(imported.containers[0].added) >= 2


CONSTANTS = """
class Set(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['ok'], input_keys=['speed'], output_keys=['seen'])
    def execute(self, userdata):
        userdata.seen = [userdata.speed, type(userdata.speed).__name__]
        return 'ok'

def build():
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        for name, speed, after in [["A", 1.5, "B"], ["B", 4, "done"]]:
            smach.StateMachine.add(name, Set(), {'ok': after}, constants={'speed': VALUE})
    return sm
"""


@pytest.mark.parametrize("target", ["bt", "sm"])
def test_a_machine_with_constants_is_one_leaf_that_does_the_same(tmp_path, target):
    file = tmp_path / "legacy_constants.py"
    file.write_text(GO + CONSTANTS.replace("VALUE", "speed"))
    imported, paths = write_recorded(file, tmp_path)
    assert verdicts(imported) == ["exact"]
    assert "'A' has constants" in texts(imported)
    outcome, ends, _ = run_task(paths["build"], target)
    assert (outcome, len(ends)) == (run_legacy(build_legacy(imported, "build"))[0], 1)


def test_what_hangs_on_an_argument_says_so_and_what_is_given_is_exact(tmp_path, capsys):
    imported = record(EXECUTED / "given_rooms.py")
    assert "failed" in verdicts(imported)
    assert "goes by `rooms`, known only in a run" in texts(imported)
    command = ["import", str(EXECUTED / "given_rooms.py"), "--from", "smach", "--execute"]
    for text in ("CleanAll: {rooms: [bath, attic]}\n", "rooms: [bath, attic]\n", '{"rooms": ["bath", "attic"]}'):
        (tmp_path / "args.yaml").write_text(text)
        assert main([*command, "--arguments", str(tmp_path / "args.yaml")]) == 0
        assert "given_rooms.py: 1 exact" in capsys.readouterr().out


MAIN = """
import rospy
import smach_ros

def main():
    rospy.init_node('x')
    sm = smach.StateMachine(outcomes=['outcome4'])
    with sm:
        smach.StateMachine.add('GO', Go(rospy.get_param('~name')), {'there': 'outcome4', 'lost': 'GO'})
    viewer = smach_ros.IntrospectionServer('x', sm, '/x')
    if rospy.get_param('~viewer', False):
        viewer.start()
    EXECUTE
    rospy.spin()

if __name__ == '__main__':
    main()
"""


@pytest.mark.parametrize(
    "execute",
    ["sm.execute()", "import threading; threading.Thread(target=sm.execute).start()", "pass", "exit(sm.execute())"],
)
def test_a_main_that_builds_and_executes_is_exact_and_its_states_are_had_again(tmp_path, monkeypatch, execute):
    file = tmp_path / "legacy_main.py"
    file.write_text(GO + MAIN.replace("EXECUTE", execute))
    imported, paths = write_recorded(file, tmp_path)
    assert (verdicts(imported), list(paths)) == (["exact"], ["legacy_main"])
    assert "`outcome4` is taken for success" in texts(imported)
    rospy = ModuleType("rospy")
    rospy.__spec__ = ModuleSpec("rospy", None)
    rospy.init_node = rospy.spin = lambda *given: None
    rospy.get_param = lambda name, default=None: default
    monkeypatch.setitem(sys.modules, "rospy", rospy)
    outcome, ends, _ = run_task(paths["legacy_main"])
    assert (outcome, ends) == ("outcome4", [("GO", "there")])


def test_an_outcome_that_means_success_can_be_said(tmp_path):
    text = BUILD.replace("OUTCOMES", "'a', 'b'").replace("EDGES", "'there': 'a', 'lost': 'b'")
    imported = recorded(tmp_path, text)
    assert dict(imported.tasks["build"].outcomes) == {"a": "success", "b": "failure"}
    assert dict(recorded(tmp_path, text, success=("b",)).tasks["build"].outcomes) == {"a": "failure", "b": "success"}


def test_a_parameter_that_changes_the_machine_is_told_and_one_that_does_not_is_none(tmp_path):
    text = """
import rospy
def build():
    sm = smach.StateMachine(['done', 'lost'])
    with sm:
        if rospy.get_param('~PARAMETER', True) and FIRST:
            smach.StateMachine.add('A', Go(), {'there': 'done'})
        else:
            smach.StateMachine.add(LABEL, Go(), {'there': 'done'})
    return sm
"""
    differs = recorded(tmp_path, text.replace("LABEL", "'B'").replace("FIRST", "True"))
    assert verdicts(differs) == ["partial"]
    assert "is another machine by the answer to `ROS parameter ~PARAMETER`" in texts(differs)
    alike = recorded(tmp_path, text.replace("LABEL", "'A'").replace("FIRST", "rospy.foo() > 3"))
    assert verdicts(alike) == ["exact"]


SURROUNDINGS = """
import os
import rospy
from arm_of_nobody import arm

FIRST = 'A' if rospy.get_param('~early', True) else 'B'

def build():
    sm = smach.StateMachine(['done', 'lost'])
    with sm:
        smach.StateMachine.add(FIRST, Go(), {'there': 'done'})
        for room in rospy.get_param('~rooms') if rospy.has_param('~rooms') else []:
            smach.StateMachine.add(room + os.environ['ARM_SIDE'], Go(), {'there': 'done'})
        if arm.ready():
            rospy.loginfo('it is ready')
        if arm.grip() is None:
            smach.StateMachine.add('NONE', Go(), {'there': 'done'})
    return sm
"""


def test_what_only_a_run_knows_is_told_by_name_and_can_be_given_under_it(tmp_path):
    early, rooms, none = "ROS parameter ~early", "ROS parameter ~rooms", "arm_of_nobody.arm.grip() is None"
    known = {early: False, rooms: ["HALL", "YARD"], "$ARM_SIDE": "_left"}
    decides = "is another machine by the answer to `"
    for given, words in [({}, early), (known, none)]:
        found = recorded(tmp_path, SURROUNDINGS, given={"": given})
        assert verdicts(found) == ["partial"]
        assert f"{decides}{words}`" in texts(found)
    (found,) = recorded(tmp_path, SURROUNDINGS, given={"": {**known, none: False}}).containers
    assert (list(found.added), found.verdict) == (["B", "HALL_left", "YARD_left"], "exact")


WRAPPED = """
class Mission(smach.StateMachine):
    def __init__(self):
        smach.StateMachine.__init__(self, outcomes=['done', 'lost'])
        both = smach.Concurrence(outcomes=['done'], default_outcome='done', outcome_cb=lambda ends: 'done')
        with both:
            smach.Concurrence.add('LEFT', Go())
        once = smach.Iterator(outcomes=['done', 'lost'], it=[1], it_label='n', input_keys=[], output_keys=[],
                              exhausted_outcome='done')
        with once:
            smach.Iterator.set_contained_state('', both, loop_outcomes=['done'])
        with self:
            smach.StateMachine.add('ONCE', once)
EXECUTE
def build():
    return Mission()
"""
EXECUTE = """
    def execute(self, *given):
        return 'lost' if super().execute(*given) == 'done' else 'done'
"""


@pytest.mark.parametrize(("execute", "outcome"), [("", "done"), (EXECUTE, "lost")])
@pytest.mark.parametrize("target", ["bt", "sm"])
def test_what_a_task_has_no_kind_for_is_one_leaf_that_does_the_same(execute, outcome, target, tmp_path):
    file = tmp_path / "legacy_wrapped.py"
    file.write_text(GO + WRAPPED.replace("EXECUTE", execute))
    imported, paths = write_recorded(file, tmp_path)
    assert set(verdicts(imported)) == {"exact"}
    assert run_task(next(iter(paths.values())), target)[0] == outcome


@pytest.mark.parametrize("packages", [(), ("lib",), ("lib", "lib/src")])
def test_packages_are_found_by_their_package_files(packages, tmp_path):
    for package, folder in (("app", "app/scripts"), ("lib", "lib/src/lib")):
        (tmp_path / folder).mkdir(parents=True)
        (tmp_path / package / "package.xml").write_text(f"<package><name>{package}</name></package>")
    (tmp_path / "lib" / "setup.py").write_text("d = dict(packages=['lib'], package_dir={'': 'src'})\n")
    (tmp_path / "lib/src/lib/__init__.py").write_text("from .states import Go\n")
    (tmp_path / "lib/src/lib/states.py").write_text(GO)
    machine = tmp_path / "lib/src/lib/machine.py"
    build = BUILD.replace("OUTCOMES", "'there', 'lost'").replace("{EDGES}", "{}")
    machine.write_text(f"import smach\nfrom lib.states import Go{build}")
    for folder in packages:  # catkin's own folder and its `src` are no packages of Python, whatever lies in them
        (tmp_path / folder / "__init__.py").touch()
    assert verdicts(record(machine)) == ["exact"]
    file = tmp_path / "app/scripts/app.py"
    file.write_text(
        "import smach\nfrom lib import Go\ntry:\n    from lib.msg import Thing\nexcept ImportError:\n    Thing = None\n"
        "def build():\n    sm = smach.StateMachine(['there', 'lost'])\n    with sm:\n"
        "        smach.StateMachine.add('GO', Go('x'))\n    return sm\n"
    )
    imported, paths = write_recorded(file, tmp_path / "out")
    assert verdicts(imported) == ["exact"]
    outcome, ends, _ = run_task(paths["build"])
    assert (outcome, ends) == ("there", [("GO", "there")])


def test_missing_classes_are_told_and_the_rest_is_recorded():
    imported = record(EXECUTED / "vendor_base.py")
    assert verdicts(imported) == ["partial"]
    assert "goes by `ROS parameter ~frame`, taken as 'FIND_BASE_LINK'" in texts(imported)
    assert "the class Take isn't here" in texts(imported)
    (container,) = imported.containers
    assert list(container.added) == ["FIND_BASE_LINK", "TAKE"]


def test_recording_executes_no_machine_and_refuses_files_and_programs(tmp_path, monkeypatch):
    forbidden = tmp_path / "forbidden"
    file = tmp_path / "harmful.py"
    file.write_text(
        (EXECUTED / "harmful.py").read_text().replace("GRIP_TEST_FILE", "PATH").replace("PATH", str(forbidden))
    )
    assert verdicts(record(file)) == ["exact"]
    assert not forbidden.exists()


def test_what_was_built_before_the_time_was_over_is_kept(tmp_path, monkeypatch):
    text = BUILD.replace("OUTCOMES", "'end'").replace("EDGES", "'there': 'end', 'lost': 'end'")
    imported = recorded(
        tmp_path,
        text + "def zz_hangs(robot):\n    build()\n    while not robot.done():\n        pass\n    while robot: pass\n",
    )
    assert verdicts(imported) == ["exact"]


def test_nothing_runs_unless_it_is_asked_for_and_a_preview_says_what_it_is(tmp_path):
    file = tmp_path / "loud.py"
    file.write_text(GO + f"open({str(tmp_path / 'ran')!r}, 'w')\n" + MAIN.replace("EXECUTE", "sm.execute()"))
    imported = import_file(file)
    assert not (tmp_path / "ran").exists()
    assert verdicts(imported) == ["partial"]
    assert "a preview of the text" in texts(imported)
    assert list(imported.containers[0].added) == ["GO"]


def test_a_preview_shows_what_is_built_where_the_text_has_literals():
    ends = lambda c: [(k, {o: v.transitions.get(o) for o in v.state.outcomes}) for k, v in c.added.items()]  # noqa: E731
    same = 0
    for file in DATA.glob("*.py"):
        shown, built = import_file(file).containers, {str(c.span): c for c in record(file).containers}
        assert all(verdict == "partial" for verdict in verdicts(import_file(file)) if verdict != "failed")
        same += sum(str(c.span) in built and bool(c.added) and ends(c) == ends(built[str(c.span)]) for c in shown)
    assert same >= 25


def test_a_file_without_smach_is_not_run(tmp_path):
    file = tmp_path / "other.py"
    file.write_text("raise SystemExit\n")
    assert record(file).containers == []


def test_a_report_on_many_files_begins_with_totals_and_says_each_thing_once(capsys):
    main(["import", str(DATA), "--from", "smach", "--report"])
    out = capsys.readouterr().out
    assert " machines in " in out.splitlines()[0]
    assert out.count("preview of the text: whether") == 1
    assert out.count("to do:") == 1
    assert "ast." not in out


TWO_WAYS = """import rospy, smach

BIG = rospy.get_param('~size') > 3

class Go(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['there'])

def machine(label):
    made = smach.StateMachine(['there'])
    with made:
        smach.StateMachine.add(label, Go())
    return made

"""


@pytest.mark.parametrize(
    "code",
    [
        "if BIG:\n    sm = smach.StateMachine(['there'])\n    with sm:\n        smach.StateMachine.add('A', Go())\n"
        "else:\n    sm = smach.StateMachine(['there'])\n    with sm:\n        smach.StateMachine.add('B', Go())\n",
        "def build():\n    if BIG:\n        made = smach.StateMachine(['there'])\n        label = 'A'\n    else:\n"
        "        made = smach.StateMachine(['there'])\n        label = 'B'\n    with made:\n"
        "        smach.StateMachine.add(label, Go())\n    return made\n",
    ],
)
def test_a_machine_that_is_made_only_without_another_isnt_exact(code, tmp_path):
    for given, expected in [({}, ["partial", "partial"]), ({"ROS parameter ~size": 5}, ["exact"])]:
        found = recorded(tmp_path, TWO_WAYS.split("def machine")[0] + code, given={"": given})
        assert [verdict for verdict in verdicts(found) if verdict != "failed"] == expected


def test_one_that_a_function_makes_whatever_is_asked_elsewhere_is_exact(tmp_path):
    code = "def one():\n    return machine('A')\n\ndef two():\n    return machine('B')\n\nbuild = one if BIG else two\n"
    assert set(verdicts(recorded(tmp_path, TWO_WAYS + code))) == {"exact"}


def test_a_message_is_never_none(tmp_path):
    code = "made = machine('A' if rospy.Duration(2) is None or rospy.Duration(2) == None else 'B')\n"
    (found,) = recorded(tmp_path, TWO_WAYS.replace("BIG = ", "#") + code).containers
    assert (list(found.added), found.verdict) == (["B"], "exact")


@pytest.mark.parametrize(
    "asked",
    [
        "made = machine('A' if hasattr(rospy, 'special') else 'B')\n",
        "made = machine('A' if getattr(rospy, 'Special', None) is not None else 'B')\n",
        "try:\n    rospy.special\n    label = 'A'\nexcept AttributeError:\n    label = 'B'\nmade = machine(label)\n",
        "try:\n    from rospy import special\n    made = machine('A')\nexcept ImportError:\n    made = machine('B')\n",
    ],
)
def test_what_a_module_has_that_is_not_here_is_known_only_in_a_run(asked, tmp_path):
    assert verdicts(recorded(tmp_path, TWO_WAYS.replace("BIG = ", "#") + asked)) == ["partial"]


def test_old_code_that_is_prepared_for_an_error_is_read_without_a_trace(tmp_path):
    code = "def made(label):\n    try:\n        rospy.loginfo(label)\n    except AttributeError, e:\n        print e\n"
    code = TWO_WAYS.replace("BIG = ", "#") + code + "made('A')\nmade = machine('A')\n"
    assert verdicts(recorded(tmp_path, code)) == ["exact"]


def test_a_folder_of_modules_is_a_package_as_python_3_has_it(tmp_path):
    parts = tmp_path / "src" / "parts"
    parts.mkdir(parents=True)
    (tmp_path / "package.xml").write_text("<package><name>lab</name></package>")
    (parts / "states.py").write_text(TWO_WAYS.split("def machine")[0])
    for folder in (tmp_path / "src" / "lab_msgs", parts / "none"):  # a ROS package, and one without modules
        folder.mkdir()
    (tmp_path / "src" / "lab_msgs" / "package.xml").write_text("<package><name>lab_msgs</name></package>")
    (tmp_path / "src" / "lab_msgs" / "gen.py").write_text("")
    code = "from parts.states import Go\nfrom lab_msgs.msg import Goal\n" + TWO_WAYS[TWO_WAYS.index("def machine") :]
    (found,) = recorded(tmp_path, "import rospy, smach\n" + code + "made = machine('A')\n").containers
    assert (found.verdict, found.added["A"].state.outcomes) == ("exact", ["there"])


OFTEN = """
FRAME = None

def frame():
    global FRAME
    if FRAME is None:
        FRAME = rospy.get_param('~frame', 'base')
    return FRAME

class Move(smach.State):
    def __init__(self, target=None):
        smach.State.__init__(self, outcomes=['there'])
        self.target = frame() + '/tip' if target is None else target
        self.fast = isinstance(rospy.Publisher('/x'), rospy.Subscriber) or rospy.get_param('~fast', False)

sm = smach.StateMachine(['there'])
with sm:
    for number in range(12):
        smach.StateMachine.add('S%d' % number, Move('%s/%d' % (frame(), number)), {'there': 'S%d' % (number + 1)})
    smach.StateMachine.add('S12', Move())
"""


def test_what_stays_as_it_is_while_a_machine_is_built_is_asked_once(tmp_path):
    assert verdicts(recorded(tmp_path, "import rospy, smach\n" + OFTEN)) == ["exact"]


@pytest.mark.parametrize("wanted", [25, 32, 39])
def test_a_question_that_keeps_machines_from_being_built_is_found(wanted):
    def first(given):
        answers = [*given, *[True] * (40 - len(given))]
        return Run(builder="build", answers=answers, error="" if not answers[wanted] else "it ended at once")

    assert any(not run.error for run in answered(first, 100))


def test_a_loop_that_asks_the_same_again_gets_no_further():
    def first(given):
        answers = [*given, *[True] * 4]
        return Run(
            builder="__main__", answers=answers, asked=[Told(what="arm.moves()", line=3)] * len(answers), error="no"
        )

    assert len(answered(first, 100)) < 30


def test_a_machine_that_begins_where_the_environment_says_is_not_exact(tmp_path):
    begins = "if os.environ.get('FIRST'):\n    sm.set_initial_state([os.environ.get('FIRST')])\n"
    assert verdicts(recorded(tmp_path, "import os, rospy, smach\n" + OFTEN + begins)) == ["partial"]
