"""What goes by chance, by the order of a set, or by a text of what is unknown: a machine by it isn't exact."""

import pytest
from smach_runs import recorded, texts, verdicts, write_recorded

METHOD = """import smach

class Go(smach.State):
    def __init__(self, name):
        smach.State.__init__(self, outcomes=['there'])

class Maker:
    def __init__(self, robot):
        self.robot = robot

    def build(self, rooms):
        made = smach.StateMachine(['there'])
        with made:
            for number, room in enumerate(rooms):
                last = number == len(rooms) - 1
                smach.StateMachine.add(room, Go(self.robot), {'there': 'there' if last else rooms[number + 1]})
        return made
"""


def test_what_a_method_and_its_class_are_given_is_written_where_each_takes_it(tmp_path):
    file = tmp_path / "maker.py"
    file.write_text(METHOD)
    given = {"": {"robot": "hero", "unused name": 3}, "Maker.build": {"rooms": ["HALL", "YARD"]}}
    imported, paths = write_recorded(file, tmp_path / "out", given=given)
    assert verdicts(imported) == ["exact"]
    text = imported.leaves.texts(tmp_path)["leaves.py"]
    assert "legacy.Maker(robot='hero').build(rooms=['HALL', 'YARD'])" in text


@pytest.mark.parametrize(
    ("added", "verdict"),
    [
        ("'A', Go(random.choice(['hello', 'hi']))", "exact"),
        ("random.choice(['A', 'B']), Go('hello')", "partial"),
        ("'A', random.choice([Go('hello'), Go('hi')])", "partial"),
        ("'A' if isinstance(random.choice(['hello', 'hi']), str) else 'B', Go('hello')", "exact"),
        ("'A' if type(random.choice(['hello', 'hi'])) in (str, list) else 'B', Go('hello')", "exact"),
        ("'A' if hasattr(random.choice(['hello', 'hi']), 'resolve') else 'B', Go('hello')", "exact"),
        ("'A' if isinstance(random.choice(['hello', 3]), str) else 'B', Go('hello')", "partial"),
    ],
)
def test_chance_that_only_a_state_goes_by_leaves_the_machine_exact(added, verdict, tmp_path):
    code = "import random, smach\n" + METHOD.split("class Maker")[0].replace("import smach", "")
    code += f"sm = smach.StateMachine(['there'])\nwith sm:\n    smach.StateMachine.add({added})\n"
    assert verdicts(recorded(tmp_path, code)) == [verdict]


@pytest.mark.parametrize(
    ("added", "verdict"),
    [
        ("'A', Go(names=list(NAMES))", "exact"),
        ("'A', Go(names=tuple(NAMES.union(['w'])))", "exact"),
        ("'A', Go(outcomes=['there', *sorted(NAMES)])", "exact"),
        ("'A', Go(outcomes=list(NAMES))", "exact"),
        ("'A', Go(outcomes=NAMES)", "exact"),
        ("list(NAMES)[0], Go()", "partial"),
        ("'A', Go(outcomes=list(NAMES)[:2])", "partial"),
        ("'A', Go(outcomes=less(list(NAMES)))", "partial"),
        ("'A' if len(''.join(list(NAMES))) == 3 and 'xyz' == ''.join(list(NAMES)) else 'B', Go()", "partial"),
        ("'A' if list(NAMES)[1] == 'y' else 'B', Go()", "partial"),
        ("[name for name in list(NAMES)][2], Go()", "partial"),
        ("'A', Go(outcomes=['there'] + list(NAMES))", "partial"),
    ],
)
def test_the_order_of_a_set_matters_only_where_a_machine_goes_by_it(added, verdict, tmp_path):
    code = """import smach
NAMES = {'x', 'y', 'z'}
class Go(smach.State):
    def __init__(self, outcomes=('there',), names=()):
        smach.State.__init__(self, outcomes=outcomes)
        self.names = names
def less(names):
    names.pop()
    return names
"""
    code += f"sm = smach.StateMachine(['there', *'xyz'])\nwith sm:\n    smach.StateMachine.add({added})\n"
    assert verdicts(recorded(tmp_path, code)) == [verdict]


SAID = """
import elsewhere

class Place:
    def METHOD(self):
        return 'at {}'.format(elsewhere.room)

sm = smach.StateMachine(outcomes=['there', 'lost'])
with sm:
    smach.StateMachine.add(LABEL, Go())
"""


@pytest.mark.parametrize("label", ["'go %r' % Place()", "f'go {Place()}'", "'go {}'.format(Place())", "str(Place())"])
def test_a_text_that_an_object_makes_of_what_is_unknown_is_one(label, tmp_path):
    text = SAID.replace("METHOD", "__repr__" if "%r" in label else "__str__").replace("LABEL", label)
    imported = recorded(tmp_path, text)
    assert verdicts(imported) == ["partial"]
    assert "elsewhere.room" in texts(imported)
