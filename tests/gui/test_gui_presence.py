"""Who looks on: names, colours, what each page shows and has selected."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest
from played import SOCKET, TestClient, until

from grip_gui.runs.pages import COLOURS, Presence
from grip_gui.wire.runs import Introduce, Selection


def viewers(frame: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {each["page"]: each for each in frame["desk"]["viewers"]} if frame["type"] == "desk" else {}


def test_everybody_sees_who_looks_on_by_name_colour_and_task(page: TestClient) -> None:
    with page.websocket_connect(SOCKET + "?page=one") as one:
        with page.websocket_connect(SOCKET + "?page=two") as two:
            seen = viewers(until(one, lambda f: len(viewers(f)) == 2))
            assert [each["name"] for each in seen.values()] == ["Viewer 1", "Viewer 2"]
            assert len({each["colour"] for each in seen.values()}) == 2
            two.send_json({"type": "introduce", "name": "  Ann   Lee ", "task": "tasks/tiny.yaml"})
            ann = viewers(until(one, lambda f: viewers(f).get("two", {}).get("task")))["two"]
            assert (ann["name"], ann["task"]) == ("Ann Lee", "tasks/tiny.yaml")
            # Two people of one name are told apart.
            one.send_json({"type": "introduce", "name": "Ann Lee"})
            until(two, lambda f: viewers(f).get("one", {}).get("name") == "Ann Lee 2")
        until(one, lambda f: f["type"] == "desk" and set(viewers(f)) == {"one"})
        # A reload: the page says its name again, and its colour is free.
        with page.websocket_connect(SOCKET + "?page=two"):
            back = viewers(until(one, lambda f: "two" in viewers(f)))["two"]
            assert back["colour"] == ann["colour"]


@pytest.mark.parametrize(
    "said", [{"name": "x" * 41}, {"name": "a\nb"}, {"name": 3}, {"task": "x" * 2000}, {"page": "two"}, {"colour": 1}]
)
def test_an_introduction_that_is_none_is_refused_and_changes_nothing(page: TestClient, said: dict[str, Any]) -> None:
    with page.websocket_connect(SOCKET + "?page=one") as one:
        until(one, lambda f: "one" in viewers(f))
        one.send_json({"type": "introduce", **said})
        assert "not understood" in until(one, lambda f: f["type"] == "refused")["reason"]
        assert page.get("/api/desk").json()["viewers"][0]["name"] == "Viewer 1"


def test_more_pages_than_colours() -> None:
    presence = Presence(lambda: None)
    pages = [f"page{number}" for number in range(3 * COLOURS)]
    for each in pages:
        presence.come(each)
    uses = Counter(each.colour for each in presence.viewers)
    assert set(uses) == set(range(COLOURS))
    assert max(uses.values()) - min(uses.values()) <= 1
    assert len({each.name for each in presence.viewers}) == len(pages)
    presence.come("")
    assert presence.connections == len(pages) + 1
    for each in pages:
        presence.go(each)
    presence.introduce("page1", Introduce(name="nobody"))
    assert presence.viewers == []
    assert presence.connections == 1


SELECTED = {"type": "selection", "task": "tasks/tiny.yaml", "nodes": ["machine/a", "first"]}


def selections(frame: dict[str, Any]) -> dict[str, Any]:
    return dict(frame["selections"]) if frame["type"] == "selections" else {}


def test_others_see_what_is_selected_until_the_page_leaves(page: TestClient) -> None:
    with page.websocket_connect(SOCKET + "?page=one") as one:
        with page.websocket_connect(SOCKET + "?page=two") as two:
            two.send_json(SELECTED)
            seen = selections(until(one, lambda f: "two" in selections(f)))
            assert seen == {"two": {"task": "tasks/tiny.yaml", "nodes": ["machine/a", "first"]}}
            # Who comes later is told of it; a page isn't told of itself.
            with page.websocket_connect(SOCKET + "?page=three") as three:
                assert set(selections(until(three, selections))) == {"two"}
                three.send_json({**SELECTED, "nodes": ["first"]})
                assert set(selections(until(two, selections))) == {"three"}
            assert selections(until(two, selections)) == {"three": None}
            two.send_json({**SELECTED, "nodes": []})
            until(one, lambda f: selections(f).get("two", "") is None)
            two.send_json(SELECTED)
            until(one, lambda f: selections(f).get("two"))
        assert selections(until(one, selections)) == {"two": None}
        # A page that comes back has nothing selected before it says so.
        with page.websocket_connect(SOCKET + "?page=two") as two, page.websocket_connect(SOCKET + "?page=late") as late:
            two.send_json({**SELECTED, "nodes": ["first"]})
            assert selections(until(late, selections))["two"]["nodes"] == ["first"]


@pytest.mark.parametrize(
    "said", [{"nodes": ["x"] * 65}, {"nodes": ["x" * 3001]}, {"nodes": "first"}, {"nodes": [1]}, {"page": "two"}]
)
def test_a_selection_that_is_none_is_refused_and_changes_nothing(page: TestClient, said: dict[str, Any]) -> None:
    with (
        page.websocket_connect(SOCKET + "?page=one") as one,
        page.websocket_connect(SOCKET + "?page=two") as two,
    ):
        two.send_json({**SELECTED, **said})
        assert "not understood" in until(two, lambda f: f["type"] == "refused")["reason"]
        two.send_json(SELECTED)
        assert selections(until(one, selections))["two"]["nodes"] == SELECTED["nodes"]


def test_the_same_selection_again_wakes_nobody() -> None:
    woken: list[None] = []
    presence = Presence(lambda: woken.append(None))
    presence.select("nobody", Selection(task="t", nodes=["a"]))
    presence.come("page")
    for _ in range(100):
        presence.select("page", Selection(task="t", nodes=["a"]))
    assert len(woken) == 2
    assert presence.selections(but="page") == {}
    assert presence.selections()["page"].nodes == ["a"]
