"""Source of the ticks of nodes of py_trees: what the closures do, in straight lines and short loops.

Every fragment leaves the node's status in `s`. Names end in the node's number: `n` the node, `k` where it resumes, `c`
the child that decided, `K` its children, `H` children with their halts, `L` leaves ticked in a loop, `t` a closure.
A composite that begins has its leaves written out one by one; one that goes on loops over what is left of them.
"""

from __future__ import annotations

from collections.abc import Callable

from py_trees.common import ParallelPolicy, Status

from .composites import halt_all, settle
from .emit_decorators import emit_update
from .emit_halts import ROW, HaltEmitter, Outer, rows_of
from .emit_ours import PRELUDE as OURS
from .emit_ours import emit_after, emit_end, emit_entry, emit_leaf
from .kinds import Kind
from .parts import INVALID, VALID, F, Inside, Part, R, S, rejected

PRELUDE = {"S": S, "F": F, "R": R, "I": INVALID, "VALID": VALID, "halt_all": halt_all, "settle": settle}


class Emitter(HaltEmitter):
    """Writes the source of one region.

    Attributes:
        insides: the nodes whose structure the source relies on.

    Args:
        inline: tells whether a child is written into its parent's source.
        outer: returns what ticks and what halts a child that isn't.
    """

    def __init__(self, inline: Callable[[Part], bool], outer: Callable[[Part], Outer]):
        super().__init__(inline, outer)
        self.write.names.update(PRELUDE, **OURS, rejected=rejected)
        self.insides: list[Part] = []
        self._classes: list[type] = []

    def classes(self) -> tuple[type, ...]:
        """Return the classes of the nodes in the source, in its order."""
        return tuple(self._classes)

    def node(self, part: Part) -> str:
        """Write the tick of a node; return its name."""
        name = self.name(part.node)
        self._classes.append(type(part.node))
        inside = part.inside
        if inside is None or not self._inline(part):
            self.write(f"s = {self.write.bind(f't{name}', self._outer(part)[0])}()")
        elif inside.kind is Kind.LEAF:
            self._leaf(name, inside)
        else:
            self.insides.append(part)
            {
                Kind.SEQUENCE: self._sequence,
                Kind.SELECTOR: self._selector,
                Kind.PARALLEL: self._parallel,
                Kind.DECORATOR: self._decorator,
            }[inside.kind](part, inside, name, name[1:])
        return name

    def _leaf(self, name: str, inside: Inside) -> None:
        write = self.write
        if inside.ours:
            emit_leaf(write, name, inside.initialises, inside.terminates)
            return
        if inside.initialises:
            write(f"if {name}.status is not R: {name}.initialise()")
        self._update(name, inside)
        if inside.builtin is not None and inside.builtin.clears:
            write(f"{name}.status = s")
            return
        with write.block("if s is not R:"):
            write(f"if s is not S and s is not F and s not in VALID: s = rejected({name}, s)")
            if inside.terminates:
                write(f"{name}.terminate(s)")
        write(f"{name}.status = s")

    def _update(self, name: str, inside: Inside) -> None:
        """Write what leaves the result of a leaf's `update` in `s`."""
        known = inside.builtin
        if known is None:
            self.write(f"s = {name}.update()")
        elif known.constant is None:
            self.write(f"s = {self.write.bind(f'u{name}', known.update)}()")
        else:
            status, message = known.constant
            self.write(f"{name}.feedback_message = {message!r}", f"s = {status.name[0]}")

    # --- sequences and selectors ---

    def _sequence(self, part: Part, inside: Inside, name: str, i: str) -> None:
        write, first = self.write, self.name(inside.kids[0].node)
        with write.block(f"if {name}.status is not R:"):
            self._enter(inside, name)
            write(f"{name}.current_child = {first}")
            self._restart(part, inside)
            self._initialise(inside, name)
            if inside.memory:
                write(f"k{i} = 0")
        if inside.memory:
            write(f"elif {name}.current_child is not None: k{i} = {self.kids(inside, i)}.index({name}.current_child)")
        with write.block("else:"):
            write(f"{name}.current_child = {first}", *([f"k{i} = 0"] if inside.memory else []))
        self._children(inside, name, i, "S", points=True)
        with write.block(f"if {'s is S' if not inside.exits else f'c{i} is None'}:"):
            self._end(part, inside, name, "S")
        self._left(inside, name, i)
        with write.block("else:"):
            if not inside.memory:
                write(f"halt_all({self._pairs(inside, i)}[{self.kids(inside, i)}.index(c{i}) + 1:])")
            write(f"s = c{i}.status")
            write(f"if s is R: {name}.status = s", f"else: {self._stop(inside, name)}(s)")

    def _selector(self, part: Part, inside: Inside, name: str, i: str) -> None:
        write, first = self.write, self.name(inside.kids[0].node)
        with write.block(f"if {name}.status is not R:"):
            self._enter(inside, name)
            write(f"{name}.current_child = p{i} = {first}")
            self._initialise(inside, name)
            if inside.memory and not inside.initialises:
                write(f"k{i} = 0")
            if inside.initialises:
                self._resume(inside, name, i)
        with write.block("else:"):
            self._resume(inside, name, i)
        self._children(inside, name, i, "F", points=False)
        with write.block(f"if {'s is F or s is I' if not inside.exits else f'c{i} is None'}:"):
            self._end(part, inside, name, "F")
            write(f"{name}.current_child = {self.name(inside.kids[-1].node)}")
        self._left(inside, name, i)
        with write.block("else:"):
            write(f"{name}.current_child = c{i}")
            kids, pairs = self.kids(inside, i), self._pairs(inside, i)
            write(f"if p{i} is not c{i}: halt_all({pairs}[{kids}.index(c{i}) + 1:])", f"s = c{i}.status")
            write(f"if s is S: {self._stop(inside, name)}(s)", f"else: {name}.status = s")

    def _resume(self, inside: Inside, name: str, i: str) -> None:
        """Write how a selector finds where it goes on."""
        write = self.write
        if inside.memory:
            write(f"assert {name}.current_child is not None")
            write(f"k{i} = {self.kids(inside, i)}.index({name}.current_child)")
            write(f"if k{i}: halt_all({self._pairs(inside, i)}[:k{i}])")
        write(f"p{i} = {name}.current_child")

    def _children(self, inside: Inside, name: str, i: str, onward: str, *, points: bool) -> None:
        """Write the ticks of all children; `s` is left as `onward` or, with the child in `c`, what the node ends by."""
        write = self.write
        if inside.exits:
            write(f"c{i} = None")
        with write.block("while True:"):
            at = 0
            for run in rows_of(inside.kids, self._inline):
                if inside.ours and len(run) > 1:
                    self._loop(run, at, inside, name, i, onward, points)
                elif not inside.memory:
                    self._row(run, at, inside, name, i, onward, points)
                else:
                    with write.block(f"if k{i} <= {at}:" if at else f"if not k{i}:"):
                        self._row(run, at, inside, name, i, onward, points)
                    if len(run) > 1:
                        with write.block("else:"):
                            self._loop(run, at, inside, name, i, onward, points)
                at += len(run)
            write("break")

    def _row(self, run: list[Part], at: int, inside: Inside, name: str, i: str, onward: str, points: bool) -> None:
        """Write one child after the other, or a loop over many leaves."""
        if len(run) > ROW:
            self._loop(run, at, inside, name, i, onward, points, whole=True)
            return
        for place, kid in enumerate(run, at):
            if points and place:
                self.write(f"{name}.current_child = {self.name(kid.node)}")
            if _bare(kid) and self._inline(kid):
                child = self.name(kid.node)
                self._classes.append(type(kid.node))
                self._bare(child, onward, i, kid)
                continue
            child = self.node(kid)
            if inside.ours:
                emit_after(self.write, name, child, inside.exits, f"c{i} = {name}")
            with self.write.block(f"if {_leaves(onward)}:"):
                self.write(f"c{i} = {child}", "break")

    def _loop(
        self,
        run: list[Part],
        at: int,
        inside: Inside,
        name: str,
        i: str,
        onward: str,
        points: bool,
        whole: bool = False,
    ) -> None:
        """Write a loop over leaves that override `update` alone; all of them if `whole`, or from where it goes on."""
        write = self.write
        self._classes.append(type(run[0].node))
        todo = self.row(run)
        if inside.memory and not whole:
            todo = f"({todo} if k{i} <= {at} else {todo}[k{i} - {at}:])"
        write(f"s = {onward}")
        with write.block(f"for n in {todo}:"):
            if points:
                write(f"{name}.current_child = n")
            if inside.ours:
                emit_leaf(write, "n", initialises=False, terminates=False)
                emit_after(write, name, "n", inside.exits, f"c{i} = {name}")
                with write.block(f"if {_leaves(onward)}:"):
                    write(f"c{i} = n", "break")
            else:
                self._bare("n", onward, i, None)
        write(f"if {_leaves(onward) if not inside.exits else f'c{i} is not None'}: break")

    def _bare(self, child: str, onward: str, i: str, kid: Part | None) -> None:
        """Write the tick of a leaf that overrides `update` alone."""
        write = self.write
        write(f"{child}.status = s = {child}.update()")
        with write.block(f"if s is not {onward}:"):
            other = "F" if onward == "S" else "S"
            write(f"if s is not R and s is not {other} and s not in VALID: {child}.status = s = rejected({child}, s)")
            if onward == "S":
                write(f"c{i} = {child}", "break")
            else:
                write(f"if s is S or s is R: c{i} = {child}; break")

    # --- parallels and decorators ---

    def _parallel(self, part: Part, inside: Inside, name: str, i: str) -> None:
        write, policy = self.write, inside.policy
        plain = type(policy) in (ParallelPolicy.SuccessOnAll, ParallelPolicy.SuccessOnOne)
        write.bind(f"P{i}", policy if plain else None)
        write(f"if {name}.policy is not P{i}: {name}.validate_policy_configuration()")
        with write.block(f"if {name}.status is not R:"):
            self._restart(part, inside)
            write(f"{name}.current_child = None")
            self._initialise(inside, name)
            known = not inside.initialises and all(kid.inside is not None for kid in inside.kids)  # all are INVALID
            write(f"y{i} = {'False' if known else f'{name}.policy.synchronise'}")
        write(f"else: y{i} = {name}.policy.synchronise")
        self._members(inside, i)
        self._settle(part, inside, name, i)

    def _members(self, inside: Inside, i: str) -> None:
        for run in rows_of(inside.kids, self._inline):
            if len(run) == 1:
                with self.write.block(f"if not y{i} or {self.name(run[0].node)}.status is not S:"):
                    self.node(run[0])
            elif len(run) > ROW:
                self._unfinished(run, i)
            else:
                with self.write.block(f"if not y{i}:"):
                    for kid in run:
                        self._classes.append(type(kid.node))
                        self._member(self.name(kid.node))
                with self.write.block("else:"):
                    self._unfinished(run, i)

    def _unfinished(self, run: list[Part], i: str) -> None:
        """Write a loop over leaves of a parallel, without those that are done."""
        with self.write.block(f"for n in {self.row(run)}:"):
            self._classes.append(type(run[0].node))
            self.write(f"if y{i} and n.status is S: continue")
            self._member("n")

    def _member(self, leaf: str) -> None:
        """Write the tick of a leaf of a parallel, which decides later."""
        wrong = "s is not S and s is not R and s is not F and s not in VALID"
        self.write(f"{leaf}.status = s = {leaf}.update()", f"if {wrong}: {leaf}.status = rejected({leaf}, s)")

    def _settle(self, part: Part, inside: Inside, name: str, i: str) -> None:
        write = self.write
        decided = f"s = settle({name}, {self.kids(inside, i)})"
        rest = decided, f"if s is not R: {self._stop(inside, name)}(s)", f"{name}.status = s"
        if type(inside.policy) is not ParallelPolicy.SuccessOnAll:
            write(*rest)
            return
        names = [self.name(kid.node) for kid in inside.kids]
        if len(names) > ROW:
            every = f"all([n.status is S for n in {self.kids(inside, i)}])"
        else:
            every = " and ".join(f"{kid}.status is S" for kid in names)
        with write.block(f"if {name}.policy is P{i} and {every}:"):
            write(f"{name}.current_child = {names[-1]}")
            self._end(part, inside, name, "S")
        with write.block("else:"):
            write(*rest)

    def _decorator(self, part: Part, inside: Inside, name: str, i: str) -> None:
        write = self.write
        stop = self._stop(inside, name)
        if inside.ours:
            self._our_decorator(inside, name, stop)
            return
        if inside.initialises:
            write(f"if {name}.status is not R: {name}.initialise()")
        child = self.node(inside.kids[0])
        emit_update(write, part.node, name, child)
        with write.block("if s is R:"):
            write(f"{name}.status = s")
        if not inside.terminates:
            with write.block(f"elif (s is S or s is F) and {child}.status is not R:"):
                write(f"{name}.status = s")
        with write.block("else:"):
            write(f"if s is not S and s is not F and s not in VALID: s = rejected({name}, s)", f"{stop}(s)")

    def _our_decorator(self, inside: Inside, name: str, stop: str) -> None:
        write = self.write
        with write.block(f"if {name}.status is not R:"):
            emit_entry(write, name)
            self._initialise(inside, name)
        with write.block("while True:"):
            child = self.node(inside.kids[0])
            emit_after(write, name, child, inside.exits, f"s = {name}.status")
            write(f"s = {name}.update()")
            write(f"if s is R: {name}.status = s")
            if not inside.terminates:
                with write.block(f"elif (s is S or s is F) and {child}.status is not R:"):
                    emit_end(write, name, None)
            with write.block("else:"):
                write(f"if s is not S and s is not F and s not in VALID: s = rejected({name}, s)", f"{stop}(s)")
            write("break")

    # --- pieces ---

    def _enter(self, inside: Inside, name: str) -> None:
        if inside.ours:
            emit_entry(self.write, name)

    def _left(self, inside: Inside, name: str, i: str) -> None:
        """Write the case that a container has ended by an exit."""
        if inside.exits:
            self.write(f"elif c{i} is {name}: s = {name}.status")

    def _restart(self, part: Part, inside: Inside) -> None:
        """Write what stops the children before they are ticked again, unless that was done in this tick already."""
        flag = self.flag(part.node)
        self.write(f"if {flag} is now: {flag} = None", f"else: {self.sweep(part, inside)}(now)")

    def _initialise(self, inside: Inside, name: str) -> None:
        if inside.initialises:
            self.write(f"{name}.initialise()")

    def kids(self, inside: Inside, i: str) -> str:
        """Return the name of the list of a node's children."""
        return self.write.bind(f"K{i}", [kid.node for kid in inside.kids])

    def _pairs(self, inside: Inside, i: str) -> str:
        """Return the name of the list of a node's children, each with what halts it."""
        halts = [kid.halt if self._inline(kid) else self._outer(kid)[1] for kid in inside.kids]
        return self.write.bind(f"H{i}", [(kid.node, halt) for kid, halt in zip(inside.kids, halts, strict=True)])

    def _stop(self, inside: Inside, name: str) -> str:
        return self.write.bind(f"stop{name}", inside.stop)

    def _end(self, part: Part, inside: Inside, name: str, status: str) -> None:
        """End with SUCCESS or FAILURE; the children are left as they are."""
        if inside.ours and not inside.terminates:
            emit_end(self.write, name, Status.SUCCESS if status == "S" else Status.FAILURE)
            self.write(f"s = {status}")
        elif inside.terminates:
            self.write(f"{self._stop(inside, name)}({status})", f"s = {status}")
        else:
            self.write(f"{name}.status = s = {status}")


def _bare(part: Part) -> bool:
    """Tell whether a node is a leaf of py_trees that overrides `update` alone."""
    inside = part.inside
    plain = inside is not None and inside.kind is Kind.LEAF and not inside.ours
    return plain and not (inside.initialises or inside.terminates or inside.builtin)  # type: ignore[union-attr]


def _leaves(onward: str) -> str:
    """Return when a child's status makes its parent leave the others."""
    return "s is not S" if onward == "S" else "s is S or s is R"
