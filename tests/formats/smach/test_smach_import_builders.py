"""What builds a machine, wherever it is: in states, methods, libraries; and what only seems to decide something."""

import pytest
from smach_runs import STEP, record, run_legacy, run_task, write_files

from grip_bt.nodes.smach_construction import built_in, run_as_main
from grip_bt.nodes.smach_source import load_legacy

WRAPPED = """
class Gate(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=['done'])
        self.inner = smach.StateMachine(outcomes=['done'])
        with self.inner:
            smach.StateMachine.add('A', Step())

    def execute(self, ud):
        return self.inner.execute()
"""
FILLED_LATER = """
import smach_ros
from robot_msgs.srv import Ask


class Pick(smach.StateMachine):
    def __init__(self):
        smach.StateMachine.__init__(self, outcomes=['done'])

    def define_for(self, robot):
        with self:
            smach.StateMachine.add('A', Step(robot.name), {'done': 'B'})
            ask = smach_ros.ServiceState(robot.url + 'ask', Ask, request_slots=['x'])
            smach.StateMachine.add('B', ask, dict.fromkeys(['succeeded', 'aborted', 'preempted'], 'done'))
        return self
"""
KIND = """
class Bracketed(smach.StateMachine):
    def __init__(self, outcomes):
        smach.StateMachine.__init__(self, outcomes)

    def execute(self, ud=smach.UserData()):
        return super().execute(ud)


def build():
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        inner = Bracketed(['done'])
        smach.StateMachine.add('INNER', inner)
        with inner:
            smach.StateMachine.add('A', Step())
    return sm
"""
SET = """
def build():
    needed = set()
    for arm in {'left', 'right'}:
        needed.add(arm)
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        smach.StateMachine.add('A', Step(str(needed)))
    return sm
"""
LABELLED = SET.replace("'A', Step(str(needed))", "'-'.join(needed), Step()")
UNPACKED = """
import rospy


def build():
    x, y = rospy.get_param('~goal', [1, 2])
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        smach.StateMachine.add('A', Step((x, y)))
    return sm
"""


ASKED_OFTEN = """
import rospy


def build():
    tool = rospy.find_tool()
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        for number in range(8):
            if tool is None or isinstance(tool, rospy.Gripper):
                rospy.loginfo('no hand')
            smach.StateMachine.add('A%d' % number, Step(tool), {'done': 'done'})
    return sm
"""
TOO_OFTEN = """
import rospy


def build():
    if not rospy.mode == 'teach':
        raise ValueError(rospy.mode)
    asked = [bool(rospy.ask(number)) for number in range(8)]
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        smach.StateMachine.add('B' if not any(asked) else 'A', Step())
    return sm
"""


CHECKED = """
from world.entity import Entity


def check(what):
    kinds = what.kind[:1] if isinstance(what.kind, list) else [what.kind]
    if kinds[0] not in (Entity, str) or what.kind not in (Entity, list):
        raise TypeError(what)


def build(place, item, room):
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        for number in range(8):
            for each in (place, item, room):
                check(each)
            smach.StateMachine.add('A%d' % number, Step((place, item, room)))
    return sm
"""
OF_TYPE = """
def build(rooms):
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        if type(rooms) is list:
            smach.StateMachine.add('A', Step(), {'done': 'B'})
        smach.StateMachine.add('B', Step())
    return sm
"""
LOGGED = """
import os
import rospy

FOLDER = os.path.join(os.path.dirname(__file__), 'logs')


def build():
    os.makedirs(FOLDER)
    os.mkdir(os.path.join(rospy.get_param('~home', '/home/robot'), 'logs'))
    with open(os.path.join(FOLDER, 'run.txt'), 'w') as file:
        file.write('built')
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        smach.StateMachine.add('A', Step())
    return sm
"""
READ_AGAIN = LOGGED.replace("'A', Step()", "'A' if os.path.isdir(FOLDER) else 'B', Step()")

CHATTY = """
import datetime
import os
import rospy


def build(robot):
    day = datetime.date.today()
    folder = os.path.join(os.path.expanduser('~'), str(day.year))
    for number in range(8):
        if not robot.has_arm(number):
            rospy.logwarn('no arm {}'.format(number))
            print(number)
        if day.day < number:
            folder += '0'
    if not os.path.isdir(folder):
        os.makedirs(folder)
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        smach.StateMachine.add('A', Step(folder))
    return sm
"""
LABELLED_BY_DAY = CHATTY.replace("'A', Step", "'A' + folder[-1:], Step")
ACTING = CHATTY.replace("print(number)", "Step.label = 'B'").replace("'A', Step", "getattr(Step, 'label', 'A'), Step")
OWN_LOG = """
class rospy:
    def logwarn(text):
        Step.label = 'B'
"""
OWN_LOG += ACTING.replace("import rospy\n", "").replace("            Step.label = 'B'\n", "").replace("(8)", "(2)")

NESTED = """
class Tidy(smach.StateMachine):
    class Door(smach.StateMachine):
        def __init__(self):
            super().__init__(outcomes=['done'])
            with self:
                self.add('OPEN', Step())

    def __init__(self):
        super().__init__(outcomes=['done'])
        with self:
            self.add('TIDY', Step())
"""
MAPPED = """
from shop import Item

if __name__ == '__main__':
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        for item in map(Item.named, ['A', 'B']):
            smach.StateMachine.add('A%d' % len(sm.get_children()), Step(item))
    sm.execute()
"""
MAPPED_UNKNOWN = """
from shop import Item, stock

if __name__ == '__main__':
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        for item in map(str, stock()):
            smach.StateMachine.add('A%d' % len(sm.get_children()), Step(item))
    sm.execute()
"""


@pytest.mark.parametrize(
    ("text", "verdicts"),
    [
        (WRAPPED, ["exact"]),
        (FILLED_LATER, ["exact"]),
        (KIND, ["exact", "exact"]),
        (SET, ["exact"]),
        (LABELLED, ["partial"]),
        (UNPACKED, ["exact"]),
        (ASKED_OFTEN, ["exact"]),
        (TOO_OFTEN, ["partial"]),
        (CHECKED, ["exact"]),
        (OF_TYPE, ["partial"]),
        (LOGGED, ["exact"]),
        (READ_AGAIN, ["partial"]),
        (CHATTY, ["exact"]),
        (LABELLED_BY_DAY, ["partial"]),
        (ACTING, ["partial"]),
        (OWN_LOG, ["partial"]),
        (NESTED, ["exact", "exact"]),
        (MAPPED, ["exact"]),
        (MAPPED_UNKNOWN, ["failed"]),
    ],
    ids=[
        *("a state with a machine", "filled by a method", "a kind of container", "a set", "labels of a set"),
        *("unpacked", "one question often", "more questions than are tried after a first try that raises"),
        *("checked by each state", "of a type"),
        *("what is written", "what is written and looked for", "what is only told", "what is told in a label"),
        *("what is told and done", "what a log of its own does"),
        *("a class in a machine that doesn't use it", "what a stand-in makes of what is known"),
        "what is made of a stand-in's items",
    ],
)
def test_what_is_built_is_found_and_is_exact_where_nothing_decides(text, verdicts, tmp_path):
    file = tmp_path / "legacy.py"
    file.write_text(STEP + text)
    assert [c.verdict for c in record(file).containers] == verdicts


def test_a_star_import_of_what_is_missing_gives_no_names_that_are_only_written(tmp_path):
    """Such as the name of the module that comes next: it would hide the package's own one."""
    package = tmp_path / "walks"
    package.mkdir()
    (package / "__init__.py").write_text("from .steps import Step\nfrom .goals import *\nfrom .mission import *\n")
    (package / "steps.py").write_text(STEP)
    (package / "goals.py").write_text("from walk_msgs.msg import *\nfrom .steps import Step\nGOAL = Goal()\n")
    (package / "mission.py").write_text(
        "import smach\nfrom . import steps\n\n\ndef build():\n    sm = smach.StateMachine(outcomes=['done'])\n"
        "    with sm:\n        smach.StateMachine.add('A', steps.Step())\n    return sm\n"
    )
    (found,) = record(package / "mission.py", tmp_path).containers
    assert (found.verdict, found.added["A"].state.cls) == ("exact", "Step")


@pytest.mark.parametrize(
    ("given", "labels"),
    [
        ({"$ROBOT": "r2", "import talk_msgs": True}, ["TALK", "r2"]),
        ({"$ROBOT": None, "import talk_msgs": False}, ["B"]),
    ],
)
def test_what_is_installed_and_set_can_be_said(given, labels, tmp_path):
    file = tmp_path / "legacy.py"
    file.write_text(
        STEP + "import os\ntry:\n    from talk_msgs.msg import Talk\nexcept ImportError:\n    Talk = None\n\n\n"
        "def build():\n    sm = smach.StateMachine(outcomes=['done'])\n    with sm:\n"
        "        for label in (['TALK'] if Talk else []) + [os.environ.get('ROBOT') or 'B']:\n"
        "            smach.StateMachine.add(label, Step())\n    return sm\n"
    )
    (found,) = record(file, given={"": given}).containers
    assert (found.verdict, list(found.added)) == ("exact", labels)


def test_a_machine_that_a_library_makes_runs_in_the_place_of_what_is_executed(tmp_path):
    """The workspace's folder without a package.xml, and the file that executes in a package of Python."""
    package = tmp_path / "mission"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "steps.py").write_text(STEP + "def machine():\n    return smach.StateMachine(outcomes=['done'])\n")
    file = package / "go.py"
    file.write_text(
        "# on smach\nfrom mission.steps import Step, machine\n\n\ndef main():\n    made = machine()\n    with made:\n"
        "        made.add('A', Step(), {'done': 'B'})\n        made.add('B', Step())\n    made.execute()\n\n\n"
        "if __name__ == '__main__':\n    main()\n"
    )
    imported = record(file)
    assert [c.verdict for c in imported.containers] == ["exact"]
    paths = {name: tmp_path / "out" / f"{name}.yaml" for name in imported.tasks}
    write_files(imported, paths, tmp_path / "out" / "nodes")
    wanted = run_legacy(built_in(file, 0, run_as_main(file)))
    for target in ("bt", "sm"):
        outcome, ends, _ = run_task(next(iter(paths.values())), target)
        assert (outcome, [path.strip("/") for path, _ in ends]) == (wanted[0], [path for path, _ in wanted[1]])


LOOKS = """
class Point(object):
    number = 0


class Look(smach.State):
    def __init__(self):
        smach.State.__init__(self, ['done'], ['number'], ['at'])

    def execute(self, ud):
        point = Point()
        point.number = ud.number + 1
        ud.at = point
        return 'done'


class Check(smach.State):
    def __init__(self):
        smach.State.__init__(self, ['kept', 'changed'], ['at'])

    def execute(self, ud):
        return 'changed' if ud.at.number else 'kept'


def build():
    sm = smach.StateMachine(outcomes=['kept', 'changed'])
    sm.userdata.at, sm.userdata.many = Point(), [1, 2]
    with sm:
        each = smach.Iterator(
            ['done'], ['at', 'many'], [], it=lambda: range(len(sm.userdata.many)), it_label='number',
            exhausted_outcome='done')
        with each:
            inner = smach.StateMachine(['done'], ['at', 'number'], ['at'])
            with inner:
                smach.StateMachine.add('LOOK', Look())
            smach.Iterator.set_contained_state('INNER', inner, loop_outcomes=['done'])
        smach.StateMachine.add('EACH', each, {'done': 'CHECK'})
        smach.StateMachine.add('CHECK', Check())
    return sm
"""


def test_a_container_that_one_leaf_runs_keeps_its_own_copies_of_what_no_task_can_hold(tmp_path):
    file = tmp_path / "legacy.py"
    file.write_text(STEP + LOOKS)
    imported = record(file)
    assert {c.verdict for c in imported.containers} == {"exact"}
    paths = {name: tmp_path / "out" / f"{name}.yaml" for name in imported.tasks}
    write_files(imported, paths, tmp_path / "out" / "nodes")
    for target in ("bt", "sm"):
        assert run_task(paths["build"], target)[0] == run_legacy(load_legacy(file).build())[0] == "kept"


ASKED = """
class Plan(smach.State):
    def __init__(self):
        smach.State.__init__(self, ['planned'], [], ['rooms'])

    def execute(self, ud):
        ud.rooms = [1, 2, 3]
        return 'planned'


class Visit(smach.State):
    def __init__(self):
        smach.State.__init__(self, ['there', 'third'], ['room'])

    def execute(self, ud):
        return 'third' if ud.room == 3 else 'there'


class House(smach.StateMachine):
    def __init__(self):
        smach.StateMachine.__init__(self, outcomes=['all', 'third'])
        each = smach.Iterator(['all', 'third'], ['rooms'], [], it=ITEMS, it_label='room', exhausted_outcome='all')
        with each:
            smach.Iterator.set_contained_state('VISIT', Visit(), loop_outcomes=['there'])
        with self:
            smach.StateMachine.add('PLAN', Plan(), {'planned': 'EACH'})
            smach.StateMachine.add('EACH', each)

    def left(self):
        return [room for room in self.userdata['rooms'] if room != 2]
"""


@pytest.mark.parametrize("items", ["self.left", "lambda: self.userdata.rooms", "lambda: [r for r in self.left()]"])
def test_items_that_ask_a_container_around_are_asked_as_the_machine_does(items, tmp_path):
    file = tmp_path / "legacy.py"
    file.write_text(STEP + ASKED.replace("ITEMS", items))
    imported = record(file)
    assert {c.verdict for c in imported.containers} == {"exact"}
    paths = {name: tmp_path / "out" / f"{name}.yaml" for name in imported.tasks}
    write_files(imported, paths, tmp_path / "out" / "nodes")
    for target in ("bt", "sm"):
        assert run_task(paths["House"], target)[0] == run_legacy(load_legacy(file).House())[0] == "third"


MISCALLED = """
class Ask(smach.State):
    def __init__(self):
        smach.StateMachine.__init__(self, outcomes=['done'])

    def execute(self, ud):
        return 'done'


def build():
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        smach.StateMachine.add('ASK', Ask())
    return sm
"""
PARAMETERS = """
import os
import rosparam
import rospy


def build():
    for values, space in rosparam.load_file(os.path.join(os.path.dirname(__file__), 'poses.yaml')):
        rosparam.upload_params(space, values)
    sm = smach.StateMachine(outcomes=['done'])
    with sm:
        for label in rospy.get_param('/poses/kitchen/names') + rospy.get_param('/hall/names', ['NO_HALL']):
            smach.StateMachine.add(label, Step())
        if rospy.has_param('/hall/door/names'):
            smach.StateMachine.add('DOOR', Step())
    return sm
"""


def test_a_state_that_calls_the_constructor_of_a_container_is_a_state_as_in_smach(tmp_path):
    file = tmp_path / "legacy.py"
    file.write_text(STEP + MISCALLED)
    (found,) = record(file).containers
    assert (found.verdict, found.added["ASK"].state.cls) == ("exact", "Ask")


@pytest.mark.parametrize(
    ("hall", "labels"),
    [({"names": ["H"], "door": {}}, ["K", "H"]), ({"door": {"names": []}}, ["K", "NO_HALL", "DOOR"])],
)
def test_parameters_that_are_given_or_uploaded_whole_are_known_by_all_their_names(hall, labels, tmp_path):
    file = tmp_path / "legacy.py"
    file.write_text(STEP + PARAMETERS)
    (tmp_path / "poses.yaml").write_text("poses: {kitchen: {names: [K]}}\n")
    (found,) = record(file, given={"": {"ROS parameter /": {"hall": hall}}}).containers
    assert (found.verdict, list(found.added)) == ("exact", labels)
