"""The prompt of `grip run --debug`: short words in, sentences out, over the control protocol."""

from __future__ import annotations

import argparse
import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any

_HELP = """\
  s, in            run to the next node that starts
  n, over          likewise, outside of this one
  o, out           likewise, outside of its parent
  t, tick          run one tick
  c, continue      continue                     p, pause   pause after this tick
  b NODE           pause before a node           b NODE:OUTCOME, b NODE:after, b NODE if EXPRESSION
  d [NUMBER]       clear a breakpoint, or all   l, list    list them
  r NODE           run to a node
  i [VARIABLE]     show the variables           q, stop    stop the run"""


class Prompt:
    """Turns words of a user into commands, and events into words; if `patient`, lines wait for the run to hold."""

    def __init__(self, send: Callable[[Mapping[str, Any]], None], say: Callable[[str], object], patient: bool = False):
        self._send, self._say = send, say
        self._held = False
        self._holds = threading.Event() if patient else None

    def listen(self, lines: Iterable[str]) -> None:
        """Obey lines until they end, which stops the run; an empty line repeats the last step."""
        last = "s"
        self._say("h for help")
        try:
            for line in lines:
                self._wait()
                text = line.strip() or last
                last = text if text in _STEPS else last
                self.obey(text)
        except (OSError, ValueError):
            pass  # the terminal is gone
        self._wait()
        self._send({"command": "stop"})

    def _wait(self) -> None:
        if self._holds is not None:
            self._holds.wait()

    def _go(self, command: str, **fields: object) -> None:
        if self._holds is not None:
            self._holds.clear()
        self._send({"command": command, **fields})

    def obey(self, text: str) -> None:
        """Obey one line."""
        word, rest = text.partition(" ")[0], text.partition(" ")[2].strip()
        if text in _STEPS:
            self._go("step", how=_STEPS[text])
        elif text in ("c", "continue", "resume"):
            self._go("resume")
        elif text in _PLAIN:
            self._send({"command": _PLAIN[text]})
        elif word in ("b", "break") and rest:
            point = breakpoint_of(rest)
            self._send({"command": "break", "if": point.pop("condition"), **point})
        elif word in ("d", "clear", "delete") and (not rest or rest.isdigit()):
            self._send({"command": "clear", **({"id": int(rest)} if rest else {})})
        elif word in ("r", "to") and rest:
            self._go("run_to", node=rest)
        elif word in ("i", "data"):
            self._send({"command": "inspect", **({"variable": rest} if rest else {})})
        else:
            self._say(_HELP if text in ("h", "help", "?") else f"{text!r} isn't a command:\n{_HELP}")

    def told(self, event: Mapping[str, Any]) -> None:
        """Say what has happened."""
        paused = event["event"] == "state" and event["state"] == "paused"
        refused = event["event"] == "refused" and event.get("command") in ("step", "run_to")
        if paused and not self._held:
            self._say("paused")
        try:
            self._tell(event)
        finally:
            self._held = event["event"] == "held"
            if self._holds is not None and (paused or event["event"] in ("ended", "failed") or refused):
                self._holds.set()

    def _tell(self, event: Mapping[str, Any]) -> None:
        match event["event"]:
            case "held":
                end = f" -> {event['outcome']}" if event["outcome"] else ""
                end += f".{event['code']}" if event["code"] else ""
                number = f" (breakpoint {event['breakpoint']})" if event["breakpoint"] else ""
                said = f": {event['message']}" if event["message"] else ""
                self._say(f"{event['when']} {event['path']}{end}{number}{said}")
            case "breakpoint":
                self._say(f"breakpoint {_point(event)}")
            case "cleared":
                self._say(f"cleared: {', '.join(map(str, event['ids'])) or 'nothing'}")
            case "breakpoints":
                self._say("\n".join(map(_point, event["breakpoints"])) or "no breakpoints")
            case "data":
                for one in event["variables"]:
                    self._say(f"  {one['name']} = {one['value']}")
                if not event["variables"]:
                    self._say("  no variable has been written")
            case "refused":
                self._say(event["message"])


def _point(facts: Mapping[str, Any]) -> str:
    outcome = f" {facts['outcome']}" if facts["outcome"] else ""
    condition = f" if {facts['if']}" if facts["if"] else ""
    return f"{facts['id']}: {facts['when']} {facts['node']}{outcome}{condition}"


_STEPS = {"step": "in"} | {
    word: how
    for letter, how in (("s", "in"), ("n", "over"), ("o", "out"), ("t", "tick"))
    for word in (letter, how, f"step {how}")
}
_PLAIN = {
    **dict.fromkeys(("p", "pause"), "pause"),
    **dict.fromkeys(("l", "list", "b", "break"), "breakpoints"),
    **dict.fromkeys(("q", "stop"), "stop"),
}


def breakpoint_of(text: str) -> dict[str, Any]:
    """Return `NODE`, `NODE:OUTCOME`, either with ` if EXPRESSION`, as what `Debugger.set` takes."""
    place, _, condition = text.partition(" if ")
    node, _, outcome = place.strip().partition(":")
    if not node:
        raise argparse.ArgumentTypeError(f"{text!r} isn't NODE, NODE:OUTCOME or NODE if EXPRESSION")
    when = outcome if outcome in ("before", "after") else ""
    return {"node": node, "when": when, "outcome": None if when else outcome or None, "condition": condition.strip()}
