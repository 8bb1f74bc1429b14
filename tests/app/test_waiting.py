"""What a run waits for is told while it waits, and nothing after."""

from __future__ import annotations

import threading

from grip_bt.app.wiring.parts import report_if_slow


def test_what_takes_its_time_is_told_once():
    told, said = [], threading.Event()

    def progress(part, words):
        told.append((part, words))
        said.set()

    with report_if_slow(progress, "robot", lambda: "no joint states", after=0.0):
        assert said.wait(120)
    assert told == [("robot", "no joint states")]


def test_what_is_quick_needs_no_words():
    told = []
    with report_if_slow(lambda *words: told.append(words), "robot", lambda: "late", after=600.0):
        pass
    assert told == []


def test_nothing_is_said_after_the_end():
    began, order = threading.Event(), []

    def progress(part, words):
        began.set()
        order.append("said")

    with report_if_slow(progress, "robot", lambda: "words", after=0.0):
        assert began.wait(120)
    order.append("over")
    assert order == ["said", "over"]
