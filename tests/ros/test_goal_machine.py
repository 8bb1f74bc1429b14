"""The life of a goal, without ROS: whatever happens, its owner is told once, in time, and no goal is left behind."""

from __future__ import annotations

import os
import sys
from collections import Counter

import pytest
from goal_world import race
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.base.failures import CanceledError, GoalRejectedError, ServerLostError, ServerTimeOutError
from grip_bt.base.operation import STOPPED
from grip_bt.ros.client.goal import LIVE, Ask, Goal, GoalEnd, GoalTimeouts, Notify, Phase

RACES = int(os.environ.get("GRIP_FUZZ_RACES", "200"))
PATIENCE = GoalTimeouts(result=10.0, cancel=2.0)


def goal(phase, patience=PATIENCE) -> Goal:
    made = Goal("/act", patience, 0.0, 0.1)
    if phase in (Phase.RUNNING, Phase.CANCELING):
        assert made.accepted(0.2) == [Ask.RESULT]
    if phase is Phase.CANCELING:
        assert made.cancel(0.3) == [Ask.CANCEL]
    assert made.phase is phase
    return made


def told(commands):
    ends = [c.end for c in commands if isinstance(c, Notify)]
    assert len(ends) == 1, commands
    return ends[0]


def test_a_goal_goes_to_its_result():
    made = goal(Phase.RUNNING)
    assert told(made.result(4, "r")) == GoalEnd("succeeded", "r")
    assert made.phase is Phase.OVER


@pytest.mark.parametrize(("number", "status"), [(4, "succeeded"), (5, "canceled"), (6, "aborted")])
def test_the_end_is_what_the_server_says(number, status):
    assert told(goal(Phase.RUNNING).result(number, None)).status == status


def test_a_server_that_does_not_know_the_goal_has_lost_it():
    error = told(goal(Phase.RUNNING).result(0, None))
    assert isinstance(error, ServerLostError)
    assert "doesn't know the goal" in str(error)


def test_a_rejected_goal_is_named():
    error = told(goal(Phase.SENT).rejected())
    assert isinstance(error, GoalRejectedError)
    assert error.code == "rejected"


def test_a_cancel_before_the_acceptance_is_sent_with_it():
    made = goal(Phase.SENT)
    assert made.cancel(0.2) == []
    assert made.accepted(0.3) == [Ask.RESULT, Ask.CANCEL]
    assert told(made.result(5, None)).status == "canceled"


def test_a_result_that_was_quicker_than_the_cancel_counts():
    assert told(goal(Phase.CANCELING).result(4, "r")) == GoalEnd("succeeded", "r")


def test_a_cancel_after_the_result_does_nothing():
    made = goal(Phase.RUNNING)
    made.result(4, None)
    assert made.cancel(1.0) == []
    assert made.cancel_answered(True, True, 20.0) == []


def test_a_cancel_that_nobody_answers_is_sent_again():
    made = goal(Phase.CANCELING)
    assert made.tick(0.4) == []
    assert made.tick(0.9) == [Ask.CANCEL]


def test_a_refused_cancel_ends_for_the_owner_and_says_so():
    made = goal(Phase.CANCELING)
    made.cancel_answered(False, True, 1.0)
    assert made.refused
    assert "refused to stop" in str(told(made.tick(2.4)))
    assert made.phase is Phase.OVER


@pytest.mark.parametrize("number", [4, 5, 6])
def test_a_goal_whose_time_is_over_is_cancelled_and_its_owner_told_when_it_has_ended(number):
    made = goal(Phase.RUNNING)
    assert made.tick(10.0) == [Ask.CANCEL]
    assert made.cancel_answered(True, True, 10.1) == []
    assert made.tick(11.9) == []
    error = told(made.result(number, None))
    assert isinstance(error, ServerTimeOutError)
    assert "no result after 10.0 s" in str(error)
    assert STOPPED not in error.data
    assert made.phase is Phase.OVER


@pytest.mark.parametrize("phase", [Phase.SENT, Phase.RUNNING])
def test_a_goal_that_nobody_says_has_ended_in_time_is_told_as_one_that_may_go_on(phase):
    made = goal(phase)
    assert made.tick(10.0) == [Ask.CANCEL]
    error, *more = made.tick(12.0)
    assert isinstance(error.end, ServerTimeOutError)
    assert error.end.data[STOPPED] is False
    assert "did not confirm the cancelling" in str(error.end)
    assert more == [Ask.CANCEL]
    assert told(goal(Phase.CANCELING).tick(2.4)).data[STOPPED] is False


def test_a_goal_taken_after_its_time_is_cancelled_then():
    made = goal(Phase.SENT)
    assert made.tick(10.0) == [Ask.CANCEL]
    assert "did not accept the goal after 10.0 s" in str(made.tick(12.0)[0].end)
    assert made.phase is Phase.ORPHANED_SENT
    assert made.accepted(30.0) == [Ask.CANCEL]
    assert made.result(5, None) == []
    assert made.phase is Phase.OVER


def test_a_goal_whose_acceptance_was_lost_runs_on_when_its_status_is_published():
    made = goal(Phase.SENT)
    assert made.status(1, 0.2) == [Ask.RESULT]
    assert made.accepted(0.3) == []
    assert told(made.result(4, "r")) == GoalEnd("succeeded", "r")


def test_a_cancel_without_an_acceptance_goes_out_by_the_goals_id():
    made = goal(Phase.SENT)
    assert made.cancel(0.2) == []
    assert made.tick(0.5) == []
    assert made.tick(0.7) == [Ask.CANCEL]
    assert made.cancel_answered(True, True, 0.8) == [Ask.RESULT]
    assert told(made.result(5, None)).status == "canceled"


def test_a_cancel_long_after_the_goal_was_sent_waits_for_no_acceptance():
    assert goal(Phase.SENT).cancel(3.0) == [Ask.CANCEL]


@pytest.mark.parametrize("stops", [True, False])
def test_a_goal_that_nobody_saw_accepted_is_cancelled_when_its_time_is_over(stops):
    made = goal(Phase.SENT)
    assert made.tick(10.0) == [Ask.CANCEL]
    assert made.cancel_answered(stops, True, 10.1) == [Ask.RESULT]
    assert (made.phase, made.refused) == (Phase.CANCELING, not stops)
    assert "did not accept the goal" in str(told(made.result(5, None)))


def test_a_cancel_that_overtakes_its_goal_is_sent_again():
    made = goal(Phase.SENT)
    made.tick(10.0)
    made.tick(12.0)
    assert made.cancel_answered(False, False, 12.1) == []
    assert made.phase is Phase.ORPHANED_SENT
    assert made.tick(12.5) == [Ask.CANCEL]


def test_a_goal_that_the_server_never_knew_is_given_up_after_long():
    made = goal(Phase.SENT)
    made.tick(10.0)
    made.tick(12.0)
    made.cancel_answered(False, False, 12.1)
    made.cancel_answered(False, False, 42.0)
    assert made.phase is Phase.ORPHANED_SENT
    made.cancel_answered(False, False, 42.2)
    assert made.phase is Phase.OVER


@pytest.mark.parametrize("phase", [Phase.SENT, Phase.RUNNING, Phase.CANCELING])
def test_a_server_that_is_gone_is_lost(phase):
    made = goal(phase, GoalTimeouts(gone=0.5))
    assert made.server_seen(False, 1.0) == []
    assert isinstance(told(made.server_seen(False, 1.5)), ServerLostError)


def test_a_server_that_was_only_out_of_sight_is_told_to_stop_when_it_is_back():
    made = goal(Phase.RUNNING)
    assert told(made.server_seen(False, 1.0)).code == "server_lost"
    assert made.server_seen(True, 2.0) == []
    assert made.tick(2.0) == [Ask.CANCEL]


def test_a_goal_of_a_server_that_stays_away_is_forgotten():
    made = goal(Phase.RUNNING)
    made.server_seen(False, 1.0)
    made.server_seen(False, 12.0)
    assert made.phase is Phase.OVER


@pytest.mark.parametrize("phase", sorted(LIVE, key=str))
def test_the_end_of_the_servers_process_ends_every_goal_with_its_reason(phase):
    made = goal(phase)
    assert "status 137" in str(told(made.server_ended("the process ended with status 137")))
    assert made.phase is Phase.OVER


def test_a_result_that_does_not_come_is_asked_for_again():
    made = goal(Phase.RUNNING)
    assert made.status(2, 1.0) == []
    assert made.status(4, 1.1) == []
    assert made.status(4, 1.5) == []
    assert made.status(4, 1.6) == [Ask.RESULT]
    assert told(made.result(4, "r")) == GoalEnd("succeeded", "r")
    assert made.status(4, 9.0) == []


def test_a_result_that_stays_away_is_asked_for_now_and_then_not_at_every_look():
    made = goal(Phase.RUNNING)
    asked = [tenths for tenths in range(40) if made.status(4, tenths / 10) == [Ask.RESULT]]
    assert asked == list(range(asked[0], 40, 5))


def test_a_goal_that_never_answers_a_cancel_is_told_to_stop_after_its_owner_has_gone():
    made = goal(Phase.CANCELING)
    assert "did not confirm the cancelling" in str(told(made.tick(2.4)))
    assert made.phase is Phase.ORPHANED
    assert [made.tick(now) for now in (2.5, 3.0)] == [[], [Ask.CANCEL]]
    assert made.cancel_answered(True, True, 3.1) == []
    assert made.phase is Phase.OVER


def test_closing_cancels_what_runs():
    end, cancel = goal(Phase.RUNNING).close(1.0)
    assert isinstance(end.end, CanceledError)
    assert cancel == Ask.CANCEL


def test_a_stale_answer_of_any_kind_changes_nothing():
    made = goal(Phase.RUNNING)
    made.result(4, None)
    for late in (made.accepted(1.0), made.rejected(), made.result(6, None), made.cancel_answered(True, True, 20.0)):
        assert late == []
    assert made.server_ended("x") == []
    assert made.tick(99.0) == []
    assert made.close(1.0) == []


EVENTS = st.sampled_from(
    [
        "seen",
        "unseen",
        "ended",
        "failed",
        "accepted",
        "rejected",
        "result",
        "unknown",
        "published",
        "yes",
        "no",
        "who",
    ]
    + ["cancel", "close", "tick"]
)


def happen(made, name, now):
    answers = {
        "seen": lambda: made.server_seen(True, now),
        "unseen": lambda: made.server_seen(False, now),
        "ended": lambda: made.server_ended("died"),
        "failed": lambda: made.send_failed(TypeError("wrong")),
        "accepted": lambda: made.accepted(now),
        "rejected": made.rejected,
        "result": lambda: made.result(4, None),
        "unknown": lambda: made.result(0, None),
        "published": lambda: made.status(4, now),
        "yes": lambda: made.cancel_answered(True, True, now),
        "no": lambda: made.cancel_answered(False, True, now),
        "who": lambda: made.cancel_answered(False, False, now),
        "cancel": lambda: made.cancel(now),
        "close": lambda: made.close(now),
        "tick": lambda: made.tick(now),
    }
    return answers[name]()


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(EVENTS, st.floats(0, 3)), max_size=30))
def test_any_order_of_events_tells_the_owner_at_most_once_and_surely_in_the_end(events):
    """Also orders that no server would produce: nothing may be sent twice, nor after the end."""
    made, now, commands = Goal("/act", PATIENCE, 0.0, 0.0), 0.0, []
    for name, pause in events:
        now += pause
        commands += happen(made, name, now)
    tells = sum(isinstance(c, Notify) for c in commands)
    assert tells == (made.phase not in LIVE)
    later = [*made.tick(now + 100.0), *made.tick(now + 200.0)]
    assert tells + sum(isinstance(c, Notify) for c in later) == 1


def test_in_random_races_every_owner_is_told_in_time_and_no_goal_is_left_behind():
    ends = Counter()
    for seed in range(RACES):
        end = race(seed).told[0]
        ends[end.status if isinstance(end, GoalEnd) else end.code] += 1
    sys.stdout.write(f"{RACES} races of goals: {dict(ends.most_common())}\n")
    assert {"succeeded", "aborted", "canceled", "server_lost", "timed_out", "rejected"} <= set(ends)
