"""Source of what our nodes add to those of py_trees: activations that are reported, labelled ends, exits, NodeErrors.

What `Node`, `Leaf` and `Container` do, line by line, for classes that leave `begin` and `conclude` as they are.
"""

from __future__ import annotations

from typing import Any, NoReturn

from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.nodes.control.container import Container
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import LABEL, Node
from grip_bt.nodes.observer import SILENT

from .kinds import conditional, replaced_on
from .writer import Writer


def failed(node: Any, error: Exception) -> NodeError:
    """Terminate a leaf that raised; return what its tick raises."""
    node._abandon(error)
    return NodeError(node.path, error)


def invalid(node: Any) -> NoReturn:
    """Raise for a leaf whose `update` returned what isn't a status."""
    wrong = TypeError("update() has to return SUCCESS, FAILURE or RUNNING")
    raise failed(node, wrong) from wrong


PRELUDE = {"failed": failed, "invalid": invalid, "SILENT": SILENT}


def plain(node: Any) -> bool:
    """Tell whether source can be written for a node of ours."""
    cls: Any = type(node)
    base: Any = Leaf if isinstance(node, Leaf) else Container
    same = cls.begin is Node.begin and cls.conclude is base.conclude
    return same and not conditional(node) and not any(replaced_on(node, name) for name in ("begin", "conclude"))


def emit_begin(write: Writer, name: str) -> None:
    """Write `Node.begin`."""
    write(f"{name}.outcome = {name}.failure = None", f"{name}.active = True")
    write(f"if {name}.observer is not SILENT: {name}.observer.entered({name}.path)")


def emit_report(write: Writer, name: str) -> None:
    """Write the end of `Node.stop`: an activation that was under way is over."""
    with write.block(f"if {name}.active:"):
        write(f"{name}.active = False", f"if {name}.observer is SILENT: pass")
        write(f"elif {name}.outcome is None: {name}.observer.interrupted({name}.path)")
        write(f"else: {name}.observer.ended({name}.path, {name}.outcome, {name}.failure)")


def emit_leaf(write: Writer, name: str, initialises: bool, terminates: bool) -> None:
    """Write `Leaf.tick`; the status is left in `s`."""
    with write.block("try:"):
        with write.block(f"if {name}.status is not R:"):
            write(f"{name}.inputs_read = {{}}")
            emit_begin(write, name)
            if initialises:
                write(f"{name}.initialise()")
        write(f"s = {name}.update()")
        with write.block("if s is not R:"):
            with write.block("if s is S or s is F:"):
                write("l = 'success' if s is S else 'failure'")  # not by a dictionary: the hash of a status is slow
                write(f"o = {name}.outcome", f"if o is None: {name}.outcome = o = l")
                write(f"if {name}.meaning.get(o) != l: {name}.conclude(s)")
            with write.block("else:"):
                write(f"if s not in VALID: s = rejected({name}, s)", f"{name}.outcome = {name}.failure = None")
            _stopped(write, name, "s", terminates)
        write(f"{name}.status = s")
    write(f"except Exception as e: raise failed({name}, e) from e", f"if s is I: invalid({name})")


def _stopped(write: Writer, name: str, status: str, terminates: bool) -> None:
    if not terminates:
        write(f"{name}.status = {status}")
        emit_report(write, name)
        return
    with write.block("try:"):
        write(f"{name}.terminate({status})", f"{name}.status = {status}")
    with write.block("finally:"):
        emit_report(write, name)


def emit_halt(write: Writer, name: str) -> None:
    """Write the `stop(INVALID)` of a leaf that doesn't override `terminate`."""
    write(f"{name}.outcome = {name}.failure = None", f"{name}.status = I")
    emit_report(write, name)


def emit_entry(write: Writer, name: str) -> None:
    """Write what a container does before its children when an activation begins."""
    write(f"{name}.last_child = None")
    emit_begin(write, name)
    write(f"if {name}.enter is not None: {name}.enter()")


def emit_after(write: Writer, name: str, child: str, exits: bool, left: str) -> None:
    """Write what a container does after a child; where it has ended by an exit, `left` and a break."""
    if not exits:
        write(f"if s is S or s is F: {name}.last_child = {child}")
        return
    with write.block("if s is S or s is F:"):
        write(f"{name}.last_child = {child}", f"o = {name}.exit_of({child})")
        with write.block("if o is not None:"):
            write(f"{name}.leave(o, {child})", left, "break")


def emit_end(write: Writer, name: str, status: Status | None) -> None:
    """Write the `stop` of a container with SUCCESS or FAILURE, in which nothing runs any more.

    Args:
        write: the source.
        name: of the container; it doesn't override `terminate`.
        status: how it ends; None where that is in `s`.
    """
    said = f'"{LABEL[status]}"' if status is not None else "'success' if s is S else 'failure'"
    write(f"if {name}.outcome is None: {name}.outcome = {said}")
    if status is Status.SUCCESS:
        write(f"{name}.failure = None")
    elif status is Status.FAILURE:
        write(f"{name}.failure = {name}.reason()")
    else:
        write(f"{name}.failure = {name}.reason() if s is F else None")
    write(f"{name}.status = {'s' if status is None else status.name[0]}")
    emit_report(write, name)
