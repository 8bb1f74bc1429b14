#!/usr/bin/env python
import smach
from smach import CBState, State, StateMachine


class Look(State):
    def __init__(self):
        State.__init__(self, outcomes=["seen", "nothing"], output_keys=["target"])
        self.views = 0

    def execute(self, userdata):
        self.views += 1
        if self.views == 1:
            return "nothing"
        userdata.target = "mug"
        return "seen"


@smach.cb_interface(outcomes=["held", "slipped"], input_keys=["thing", "force"], output_keys=["tries"])
def grasp(userdata, *args):
    userdata.tries = userdata.force
    return "held" if userdata.force >= 3 else "slipped"


def build():
    sm = StateMachine(outcomes=["succeeded", "aborted"], output_keys=["tries"])
    sm.userdata.force = 3
    with sm:
        StateMachine.add("LOOK", Look(), {"seen": "GRASP", "nothing": "LOOK"})
        StateMachine.add(
            "GRASP",
            CBState(grasp),
            {"held": "succeeded", "slipped": "aborted"},
            remapping={"thing": "target"},
        )
    return sm

if __name__ == '__main__':
    print(build().execute())
