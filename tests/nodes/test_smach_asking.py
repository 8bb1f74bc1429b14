"""How preempt requests travel among leaves that no container of SMACH's is around, or one that tasks have put in."""

from grip_bt.nodes.smach_asking import Asking, Enclosing


class State:
    def __init__(self):
        self.flag = self.runs = False

    def request_preempt(self):
        self.flag = True

    def preempt_requested(self):
        return self.flag

    def recall_preempt(self):
        self.flag = False

    def is_running(self):
        return self.runs


def begin(asking, state, requests, *around):
    asking.begin(around, state, requests)
    state.runs = True


class Machine(Enclosing):
    def __init__(self, path, kind="StateMachine"):
        self.on, self.open = True, 0
        super().__init__(path, kind, lambda: self.on, lambda: self.open)
        self.entered()


def test_states_that_a_task_runs_at_once_are_all_asked():
    asking, left, right = Asking(), State(), State()
    begin(asking, left, 0)
    begin(asking, right, 0)
    asking.arrive(1)
    assert (left.flag, right.flag) == (True, True)


def test_one_that_begins_beside_the_asked_one_is_asked_and_takes_nothing_from_it():
    asking, left, right = Asking(), State(), State()
    begin(asking, left, 0)
    asking.arrive(1)
    begin(asking, right, 1)
    assert (left.flag, right.flag) == (True, True)


def test_a_request_travels_until_somebody_has_answered_and_a_new_one_begins_anew():
    asking, states = Asking(), [State() for _ in range(4)]
    seen = []
    for number, state in enumerate(states):
        begin(asking, state, 2 if number == 3 else 1)
        seen.append(state.flag)
        state.runs = False
        if number == 1:
            state.flag = False
    assert seen == [True, True, False, True]


def test_a_machine_that_is_left_with_its_request_unanswered_is_asked_by_it_when_it_is_entered_again():
    asking, outer, inner = Asking(), Machine("outer"), Machine("outer/inner")
    ignores, other, later = State(), State(), State()
    begin(asking, ignores, 0, outer, inner)
    asking.arrive(1)
    ignores.runs, inner.on = False, False
    begin(asking, other, 1, outer)
    assert other.flag, "it travels on from the machine, whose flag is taken back"
    other.flag = other.runs = False
    inner.on = True
    inner.entered()
    begin(asking, later, 1, outer, inner)
    assert not later.flag


def test_a_concurrence_that_is_entered_with_a_request_tells_nobody_and_knows_it_at_its_end():
    asking, both = Asking(), Machine("both", "Concurrence")
    one, two = State(), State()
    begin(asking, one, 1, both)
    begin(asking, two, 1, both)
    assert (one.flag, two.flag) == (False, False)
    assert asking.container(both).obeyed()
    assert not asking.container(both).flag, "it was answered"


def test_a_child_of_a_concurrence_that_has_ended_isnt_asked_and_an_unanswered_request_is_taken_back():
    asking, both = Asking(), Machine("both", "Concurrence")
    ended, runs, late = State(), State(), State()
    begin(asking, ended, 0, both)
    begin(asking, runs, 0, both)
    ended.runs = False
    asking.arrive(1)
    begin(asking, late, 1, both)
    assert (ended.flag, runs.flag, late.flag) == (False, True, True)
    assert not asking.container(both).obeyed()
    assert (runs.flag, late.flag, asking.container(both).flag) == (False, False, True)


def test_an_iterator_keeps_a_request_only_where_its_items_have_run_out():
    for exhausted in (False, True):
        asking, outer, each = Asking(), Machine("outer"), Machine("outer/each", "Iterator")
        item, after = State(), State()
        begin(asking, item, 0, outer, each)
        asking.arrive(1)
        assert item.flag
        asking.container(each).exhausted = exhausted
        item.runs = each.on = False
        begin(asking, after, 1, outer)
        assert after.flag is exhausted
