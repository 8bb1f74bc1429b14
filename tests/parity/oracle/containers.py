"""The kinds of containers, each as its row in the tables of docs/semantics.md says."""

from __future__ import annotations

from typing import Any

from .node import SUCCESS, Container, End, Node, code_first, failure


class _Ordered(Container):
    """Children in order, until one ends with the meaning that decides."""

    deciding: str
    last: End

    def begin(self) -> None:
        self.at = 0

    def work(self) -> End | None:
        memory, end = self.document.get("memory", True), self.last
        for place in range(self.at if memory else 0, len(self.children)):
            self.at = place
            said = self.ask(self.children[place])
            if said is None or said.meaning == self.deciding:
                if not memory:
                    for later in self.children[place + 1 :]:
                        later.halt()
                return None if said is None else self.plain(said)
            end = said
        return self.plain(end)

    def plain(self, end: End) -> End:
        return failure(end.code) if end.meaning == "failure" else SUCCESS


class Sequence(_Ordered):
    deciding, last = "failure", SUCCESS


class Fallback(_Ordered):
    deciding, last = "success", failure()


class StateMachine(Container):
    def begin(self) -> None:
        self.current = self.named(self.document["initial"])

    def named(self, name: str) -> Node:
        return next(child for child in self.children if child.name == name)

    def work(self) -> End | None:
        end = self.current.tick()
        if end is None:
            return None
        target = code_first(self.current.document["on"], "", end)
        assert target is not None, f"no edge leaves {self.current.path} by {end}"
        if any(child.name == target for child in self.children):
            self.current = self.named(target)
            return None
        return End(target, self.document["outcomes"][target], end.code)


class Retry(Container):
    def begin(self) -> None:
        self.left = self.document["times"]

    def work(self) -> End | None:
        end = self.ask(self.child)
        if end is None or end.meaning == "success":
            return end and SUCCESS
        self.left -= 1
        return None if self.left else failure(end.code)


class Repeat(Container):
    def begin(self) -> None:
        self.left = self.document.get("times")

    def work(self) -> End | None:
        end = self.ask(self.child)
        if end is None or end.meaning == "failure":
            return end and failure(end.code)
        if self.left is not None:
            self.left -= 1
        return SUCCESS if self.left == 0 else None


class Timeout(Container):
    def begin(self) -> None:
        self.deadline = self.run.now + self.document["seconds"]

    def work(self) -> End | None:
        late = self.document.get("child_first", False)
        if not late and self.run.now >= self.deadline:
            return failure("time_out")
        end = self.ask(self.child)
        if end is None:
            return failure("time_out") if late and self.run.now >= self.deadline else None
        return failure(end.code) if end.meaning == "failure" else SUCCESS


class Guard(Container):
    def work(self) -> End | None:
        if not self.holds(self.document["if"]):
            return failure("guard")
        end = self.ask(self.child)
        return end and (failure(end.code) if end.meaning == "failure" else SUCCESS)


class Invert(Container):
    def work(self) -> End | None:
        end = self.ask(self.child)
        return end and (failure() if end.meaning == "success" else SUCCESS)


class Force(Container):
    def work(self) -> End | None:
        end = self.ask(self.child)
        return end and (failure(end.code) if self.document["as"] == "failure" else SUCCESS)


class _Choosing(Container):
    """What chooses where nothing runs, then ticks whom it chose."""

    again = False
    chosen: Node | None = None

    def begin(self) -> None:
        self.chosen = None

    def choose(self) -> Node | End:
        raise NotImplementedError

    def work(self) -> End | None:
        if self.chosen is None:
            choice = self.choose()
            if isinstance(choice, End):
                return choice
            self.chosen = choice
        end = self.ask(self.chosen)
        if end is None:
            return None
        if end.meaning == "success" and self.again:
            self.chosen = None
            return None
        return failure(end.code) if end.meaning == "failure" else SUCCESS


class Switch(_Choosing):
    def choose(self) -> Node | End:
        value = self.value(self.document["on_value"])
        for name, said in self.document["cases"].items():
            if any(same(value, literal) for literal in (said if isinstance(said, list) else [said])):
                return self.named(name)
        default = self.document.get("default")
        return self.named(default) if default else failure("no_case")

    def named(self, name: str) -> Node:
        return next(child for child in self.children if child.name == name)

    def work(self) -> End | None:
        if self.document.get("memory", True) or self.chosen is None:
            return super().work()
        choice = self.choose()
        if choice is not self.chosen:
            self.chosen.halt()
            if isinstance(choice, End):
                return choice
            self.chosen = choice
        return super().work()


def same(value: Any, literal: Any) -> bool:
    """Tell whether a value is what a file says: 1 is 1.0, but neither true nor "1"."""
    return isinstance(value, bool) == isinstance(literal, bool) and bool(value == literal)


class Loop(_Choosing):
    again = True

    def begin(self) -> None:
        super().begin()
        self.left = self.document.get("times")

    def choose(self) -> Node | End:
        condition = self.document.get("while")
        if condition is not None and not self.holds(condition):
            return SUCCESS
        if self.left == 0:
            return failure("loop_limit")
        if self.left is not None:
            self.left -= 1
        return self.child


class ForEach(_Choosing):
    again = True

    def own_variables(self) -> dict[str, Any]:
        return {**super().own_variables(), self.document["item"]: "int"}

    def begin(self) -> None:
        super().begin()
        self.items: list[Any] | None = None

    def choose(self) -> Node | End:
        if self.items is None:
            self.items = list(self.computed(lambda: self.scope.read(self.document["items"])))
        if not self.items:
            return SUCCESS
        self.write(self.document["item"], self.items.pop(0))
        return self.child


class Cooldown(_Choosing):
    ready = float("-inf")
    """When it may be run again; it lasts through a run."""

    def choose(self) -> Node | End:
        return failure("cooldown") if self.run.now < self.ready else self.child

    def over(self) -> None:
        if self.chosen is not None:
            self.ready = self.run.now + self.document["seconds"]


class RoundRobin(_Choosing):
    turns = 0
    """How many there were; it lasts through a run."""

    def choose(self) -> Node | End:
        self.turns += 1
        return self.children[(self.turns - 1) % len(self.children)]


class Parallel(Container):
    def begin(self) -> None:
        self.ends: dict[str, End] = {}
        self.verdict: End | None = None

    def work(self) -> End | None:
        if not self.children:
            return SUCCESS
        retick, prompt = self.document.get("retick", False), self.document.get("prompt", False)
        for child in self.children:
            if retick:
                self.ends.pop(child.name, None)
            if child.name not in self.ends:
                end = child.tick()
                if end is not None:
                    self.ends[child.name] = end
                if prompt and self.decided():
                    return self.verdict
        return self.verdict if self.decided() and self.may_end() else None

    def decided(self) -> bool:
        """Decide, unless that was done before: the first decision stands."""
        if self.verdict is None and (self.document.get("cancel") != "join" or self.all_ended()):
            self.verdict = self.decision()
        return self.verdict is not None

    def all_ended(self) -> bool:
        return len(self.ends) == len(self.children)

    def may_end(self) -> bool:
        return self.document.get("cancel", "halt") == "halt" or self.all_ended()

    def asks_to_stop(self) -> bool:
        return self.document.get("cancel") == "ask" and self.running and self.verdict is not None

    def decision(self) -> End | None:
        """Nothing before those have ended that are waited for; then exits, rules, and the policy."""
        if not self.waited():
            return None
        in_order = [(child, self.ends[child.name]) for child in self.children if child.name in self.ends]
        for child, end in in_order:
            leaving = self.exit(child, end)
            if leaving is not None:
                return leaving
        reason = next((end.code for _, end in in_order if end.meaning == "failure"), None)
        complete = self.all_ended() or "wait_for" in self.document
        for rule in self.document.get("rules", ()):
            if self.matches(rule, complete):
                return End(rule["then"], self.meaning[rule["then"]], reason)
        there = [end.meaning for _, end in in_order]
        if complete and ("rules" in self.document or "wait_for" in self.document):
            return self.by_policy(there, len(there), reason)
        return None if "rules" in self.document else self.by_policy(there, len(self.children), reason)

    def waited(self) -> bool:
        if self.all_ended():
            return True
        match self.document.get("wait_for"):
            case None:
                return True
            case "all":
                return False
            case "any":
                return bool(self.ends)
            case int(number):
                return len(self.ends) >= number
            case names:
                return all(name in self.ends for name in names)

    def matches(self, rule: dict[str, Any], complete: bool) -> bool:
        if "when" not in rule and "at_least" not in rule:
            return complete
        for name, said in rule.get("when", {}).items():
            labels = said if isinstance(said, list) else [said]
            end = self.ends.get(name)
            if end is None or not {end.outcome, f"{end.outcome}.{end.code}"} & set(labels):
                return False
        meaning = rule.get("ends", "success")
        return sum(end.meaning == meaning for end in self.ends.values()) >= rule.get("at_least", 0)

    def by_policy(self, there: list[str], number: int, reason: str | None) -> End | None:
        """Go by the ends that are there, of so many that count."""
        deciding, other = (
            ("failure", "success") if self.document.get("policy", "all") == "all" else ("success", "failure")
        )
        meaning = deciding if deciding in there else other if len(there) == number else None
        if meaning is None:
            return None
        return failure(reason) if meaning == "failure" else SUCCESS


KINDS: dict[str, type[Container]] = {
    "sequence": Sequence,
    "fallback": Fallback,
    "parallel": Parallel,
    "state_machine": StateMachine,
    "retry": Retry,
    "repeat": Repeat,
    "timeout": Timeout,
    "guard": Guard,
    "switch": Switch,
    "loop": Loop,
    "for_each": ForEach,
    "cooldown": Cooldown,
    "round_robin": RoundRobin,
    "invert": Invert,
    "force": Force,
}
