"""What is said to have made an attempt fail."""

from __future__ import annotations

from trial_attempts import AttemptRecorder

from grip_bt.base.values import Failure

LEFT, LOST = Failure("something_left", "", {}), Failure("no_contact", "", {})


def test_what_a_part_of_the_attempt_has_dealt_with_is_no_reason():
    recorder = AttemptRecorder("try", "try/held", clock=lambda: 0.0)
    recorder.entered("try")
    recorder.ended("try/todo/clear", "failure", LEFT)
    recorder.ended("try/todo", "success", None)
    recorder.ended("try/todo_no_more", "success", None)
    recorder.ended("try/pick/close", "failure", LOST)
    recorder.ended("try/pick/back_off", "success", None)
    recorder.ended("try/pick", "missed", None)
    recorder.ended("try", "failure", None)
    (attempt,) = recorder.attempts
    assert (attempt.failure, attempt.where) == (LOST, "pick/close")


def test_the_first_failure_is_the_reason_where_nothing_dealt_with_it():
    recorder = AttemptRecorder("try", "try/held", clock=lambda: 0.0)
    recorder.entered("try")
    recorder.ended("try/look/clear", "failure", LEFT)
    recorder.ended("try/loo", "success", None)
    recorder.ended("try/close", "failure", LOST)
    recorder.ended("try", "failure", None)
    assert (recorder.attempts[0].failure, recorder.attempts[0].where) == (LEFT, "look/clear")
