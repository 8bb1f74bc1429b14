"""Source of the ticks of nodes of py_trees: what the closures do, in straight lines and short loops.

Every fragment leaves the node's status in `s`. Names end in the node's number: `n` the node, `k` where it resumes, `c`
the child that decided, `K` its children, `H` children with their halts, `L` leaves ticked in a loop, `t` a closure.
"""

from __future__ import annotations

from collections.abc import Callable

from py_trees.common import ParallelPolicy, Status

from .composites import halt_all, settle
from .emit_decorators import emit_update
from .emit_halts import LOOP, HaltEmitter, Outer, runs_of
from .emit_ours import PRELUDE as OURS
from .emit_ours import emit_after, emit_end, emit_entry, emit_leaf
from .kinds import Kind
from .parts import INVALID, VALID, F, Inside, Part, R, S, rejected

PRELUDE = {"S": S, "F": F, "R": R, "I": INVALID, "VALID": VALID, "halt_all": halt_all, "settle": settle}


class Emitter(HaltEmitter):
    """Writes the source of one region.

    Attributes:
        write: what was written.
        insides: the nodes whose structure the source relies on.
        functions: the source of functions that stop inner nodes.
        resets: ids of inner nodes that their parents may stop -> the variables that tell so; false at first.

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
        number = self.write.number()
        name = self.write.bind(f"n{number}", part.node)
        self._classes.append(type(part.node))
        inside = part.inside
        if inside is None or not self._inline(part):
            self.write(f"s = {self.write.bind(f't{number}', self._outer(part)[0])}()")
        elif inside.kind is Kind.LEAF:
            self._leaf(name, inside)
        else:
            self.insides.append(part)
            {
                Kind.SEQUENCE: self._sequence,
                Kind.SELECTOR: self._selector,
                Kind.PARALLEL: self._parallel,
                Kind.DECORATOR: self._decorator,
            }[inside.kind](part, inside, name, str(number))
        return name

    def _leaf(self, name: str, inside: Inside) -> None:
        write = self.write
        if inside.ours:
            emit_leaf(write, name, inside.initialises, inside.terminates)
            return
        if inside.initialises:
            write(f"if {name}.status is not R: {name}.initialise()")
        write(f"s = {name}.update()")
        with write.block("if s is not R:"):
            write(f"if s is not S and s is not F and s not in VALID: s = rejected({name}, s)")
            if inside.terminates:
                write(f"{name}.terminate(s)")
        write(f"{name}.status = s")

    # --- sequences and selectors ---

    def _sequence(self, part: Part, inside: Inside, name: str, i: str) -> None:
        write = self.write
        first = self._first(part, i)
        with write.block(f"if {name}.status is not R:"):
            self._enter(inside, name)
            write(f"{name}.current_child = {first}")
            self._restart(part, inside, i)
            self._initialise(inside, name)
            write(f"k{i} = 0")
        if inside.memory:
            write(f"elif {name}.current_child is not None: k{i} = K{i}.index({name}.current_child)")
        with write.block("else:"):
            write(f"{name}.current_child = {first}", f"k{i} = 0")
        self._children(inside, name, i, bool(inside.memory), "S", "s is not S", points=True)
        with write.block(f"if c{i} is None:"):
            self._end(inside, name, i, "S")
        self._left(inside, name, i)
        with write.block("else:"):
            if not inside.memory:
                write(f"halt_all(H{i}[K{i}.index(c{i}) + 1:])")
            write(f"s = c{i}.status")
            write(f"if s is R: {name}.status = s", f"else: stop{i}(s)")

    def _selector(self, part: Part, inside: Inside, name: str, i: str) -> None:
        write = self.write
        first = self._first(part, i)
        with write.block(f"if {name}.status is not R:"):
            self._enter(inside, name)
            write(f"{name}.current_child = {first}")
            self._initialise(inside, name)
        self._pairs(inside, i)
        if inside.memory:
            write(f"assert {name}.current_child is not None", f"k{i} = K{i}.index({name}.current_child)")
            write(f"if k{i}: halt_all(H{i}[:k{i}])")
        write(f"p{i} = {name}.current_child")
        self._children(inside, name, i, bool(inside.memory), "F", "s is S or s is R", points=False)
        with write.block(f"if c{i} is None:"):
            self._end(inside, name, i, "F")
            write(f"{name}.current_child = K{i}[-1]")
        self._left(inside, name, i)
        with write.block("else:"):
            write(f"{name}.current_child = c{i}")
            write(f"if p{i} is not c{i}: halt_all(H{i}[K{i}.index(c{i}) + 1:])", f"s = c{i}.status")
            write(f"if s is S: stop{i}(s)", f"else: {name}.status = s")

    def _children(
        self, inside: Inside, name: str, i: str, memory: bool, onward: str, leaves: str, *, points: bool
    ) -> None:
        """Write the ticks of all children; the one at which the node ends is left in `c`."""
        write = self.write
        self._pairs(inside, i)
        write.bind(f"stop{i}", inside.stop)
        write(f"c{i} = None")
        with write.block("while True:"):
            at = 0
            for run in runs_of(inside.kids, self._inline):
                if len(run) >= LOOP:
                    self._classes.append(type(run[0].node))
                    self._loop(run, at, inside, name, i, onward, leaves, points)
                elif memory and at:
                    with write.block(f"if k{i} <= {at}:"):
                        self._child(run[0], at, inside, name, i, leaves, points)
                elif memory:
                    with write.block(f"if not k{i}:"):
                        self._child(run[0], at, inside, name, i, leaves, points)
                else:
                    self._child(run[0], at, inside, name, i, leaves, points)
                at += len(run)
            write("break")

    def _child(self, kid: Part, at: int, inside: Inside, name: str, i: str, leaves: str, points: bool) -> None:
        if points and at:
            self.write(f"{name}.current_child = {self.write.bind(f'n{i}_{at}', kid.node)}")
        child = self.node(kid)
        if inside.ours:
            emit_after(self.write, name, child, inside.exits, f"c{i} = {name}")
        with self.write.block(f"if {leaves}:"):
            self.write(f"c{i} = {child}", "break")

    def _loop(
        self, run: list[Part], at: int, inside: Inside, name: str, i: str, onward: str, leaves: str, points: bool
    ) -> None:
        """Write a loop over leaves that override `update` alone."""
        write = self.write
        todo = write.bind(f"L{i}_{at}", [kid.node for kid in run])
        if inside.memory:
            todo = f"({todo} if k{i} <= {at} else {todo}[k{i} - {at}:])"
        with write.block(f"for n in {todo}:"):
            if points:
                write(f"{name}.current_child = n")
            if inside.ours:
                emit_leaf(write, "n", initialises=False, terminates=False)
                emit_after(write, name, "n", inside.exits, f"c{i} = {name}")
                with write.block(f"if {leaves}:"):
                    write(f"c{i} = n", "break")
            else:
                self._bare(onward, leaves, i)
        write(f"if c{i} is not None: break")

    def _bare(self, onward: str, leaves: str, i: str) -> None:
        write = self.write
        write("n.status = s = n.update()")
        with write.block(f"if s is not {onward}:"):
            write("if s is not S and s is not R and s is not F and s not in VALID: n.status = s = rejected(n, s)")
            with write.block(f"if {leaves}:"):
                write(f"c{i} = n", "break")

    # --- parallels and decorators ---

    def _parallel(self, part: Part, inside: Inside, name: str, i: str) -> None:
        write = self.write
        plain = type(inside.policy) in (ParallelPolicy.SuccessOnAll, ParallelPolicy.SuccessOnOne)
        write.bind(f"P{i}", inside.policy if plain else None)
        write.bind(f"stop{i}", inside.stop)
        write(f"if {name}.policy is not P{i}: {name}.validate_policy_configuration()")
        with write.block(f"if {name}.status is not R:"):
            self._restart(part, inside, i)
            write(f"{name}.current_child = None")
            self._initialise(inside, name)
        write.bind(f"K{i}", [kid.node for kid in inside.kids])
        write(f"y{i} = {name}.policy.synchronise")
        self._members(inside, i)
        if type(inside.policy) is ParallelPolicy.SuccessOnAll:
            self._settle_all(inside, name, i)
        else:
            write(f"s = settle({name}, K{i})", f"if s is not R: stop{i}(s)", f"{name}.status = s")

    def _members(self, inside: Inside, i: str) -> None:
        write, at = self.write, 0
        for run in runs_of(inside.kids, self._inline):
            if len(run) >= LOOP:
                self._classes.append(type(run[0].node))
                with write.block(f"for n in {write.bind(f'L{i}_{at}', [kid.node for kid in run])}:"):
                    write(f"if y{i} and n.status is S: continue", "n.status = s = n.update()")
                    with write.block("if s is not S and s is not R and s is not F and s not in VALID:"):
                        write("n.status = rejected(n, s)")
            else:
                with write.block(f"if not y{i} or {write.bind(f'n{i}_{at}', run[0].node)}.status is not S:"):
                    self.node(run[0])
            at += len(run)

    def _settle_all(self, inside: Inside, name: str, i: str) -> None:
        write = self.write
        with write.block(f"for n in K{i}:"):
            with write.block(f"if n.status is not S or {name}.policy is not P{i}:"):
                write(f"s = settle({name}, K{i})", f"if s is not R: stop{i}(s)", f"{name}.status = s", "break")
        with write.block("else:"):
            write(f"{name}.current_child = K{i}[-1]")
            self._end(inside, name, i, "S")

    def _decorator(self, part: Part, inside: Inside, name: str, i: str) -> None:
        write = self.write
        write.bind(f"stop{i}", inside.stop)
        if inside.ours:
            self._our_decorator(inside, name, i)
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
            write(f"if s is not S and s is not F and s not in VALID: s = rejected({name}, s)", f"stop{i}(s)")

    def _our_decorator(self, inside: Inside, name: str, i: str) -> None:
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
                write(f"if s is not S and s is not F and s not in VALID: s = rejected({name}, s)", f"stop{i}(s)")
            write("break")

    # --- pieces ---

    def _enter(self, inside: Inside, name: str) -> None:
        if inside.ours:
            emit_entry(self.write, name)

    def _left(self, inside: Inside, name: str, i: str) -> None:
        """Write the case that a container has ended by an exit."""
        if inside.exits:
            self.write(f"elif c{i} is {name}: s = {name}.status")

    def _restart(self, part: Part, inside: Inside, i: str) -> None:
        """Write what stops the children before they are ticked again, unless the parent has just done so."""
        reset = self.resets.get(id(part.node))
        if reset is None:
            self._halts(inside, i, self.write)
        else:
            with self.write.block(f"if not {reset}:"):
                self._halts(inside, i, self.write)

    def _first(self, part: Part, i: str) -> str:
        assert part.inside is not None
        return self.write.bind(f"f{i}", part.inside.kids[0].node)

    def _initialise(self, inside: Inside, name: str) -> None:
        if inside.initialises:
            self.write(f"{name}.initialise()")

    def _pairs(self, inside: Inside, i: str) -> None:
        self.write.bind(f"K{i}", [kid.node for kid in inside.kids])
        halts = [kid.halt if self._inline(kid) else self._outer(kid)[1] for kid in inside.kids]
        self.write.bind(f"H{i}", [(kid.node, halt) for kid, halt in zip(inside.kids, halts, strict=True)])

    def _end(self, inside: Inside, name: str, i: str, status: str) -> None:
        """End with SUCCESS or FAILURE; the children are left as they are."""
        if inside.ours and not inside.terminates:
            emit_end(self.write, name, Status.SUCCESS if status == "S" else Status.FAILURE)
            self.write(f"s = {status}")
            return
        self.write(f"stop{i}({status})" if inside.terminates else f"{name}.status = {status}", f"s = {status}")
