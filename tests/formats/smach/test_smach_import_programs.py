"""Programs in packages, which import what lies beside them."""

import pytest
from smach_runs import STEP, record

MACHINES = """
class Tidy(smach.StateMachine):
    def __init__(self, rooms):
        super().__init__(outcomes=['done'])
        with self:
            for room in rooms:
                self.add(room, Step())
"""
PROGRAM = """
from .machines import Tidy
import drive

while not drive.arm.is_up():
    drive.arm.wait()
if __name__ == '__main__':
    sm = Tidy(ROOMS)
    sm.execute()
"""


@pytest.mark.parametrize(
    ("rooms", "given", "told"),
    [
        ("drive.rooms", {"drive.rooms": ["hall"], "drive.arm.is_up()": True}, None),
        ("drive.rooms[1] + 1", {"drive.rooms": ["hall"], "drive.arm.is_up()": True}, "list index out of range"),
    ],
)
def test_a_program_in_a_package_is_run_in_it_and_one_that_does_not_finish_is_told(rooms, given, told, tmp_path):
    (tmp_path / "tidying").mkdir()
    (tmp_path / "tidying" / "__init__.py").touch()
    (tmp_path / "tidying" / "machines.py").write_text(STEP + MACHINES)
    file = tmp_path / "tidying" / "program.py"
    file.write_text("import smach\n" + PROGRAM.replace("ROOMS", rooms))
    found = record(file, given={"": given}).containers
    if told is None:
        assert [(each.cls, each.verdict, list(each.added)) for each in found] == [("Tidy", "exact", ["hall"])]
    else:
        assert [(each.cls, each.verdict) for each in found] == [("Tidy", "failed")]
        assert told in found[0].issues[0].message
