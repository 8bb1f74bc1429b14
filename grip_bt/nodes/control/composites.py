"""Sequence and fallback: py_trees' own, with labelled exits."""

from __future__ import annotations

from collections.abc import Iterable

from py_trees import composites
from py_trees.behaviour import Behaviour

from .container import Container, Face


class Sequence(Container, composites.Sequence):
    """Children in order until one fails."""

    def __init__(self, face: Face, children: Iterable[Behaviour], memory: bool = True):
        composites.Sequence.__init__(self, face.name, memory, list(children))
        self.take(face)


class Fallback(Container, composites.Selector):
    """Children in order until one succeeds; it fails with the reason of the last one."""

    def __init__(self, face: Face, children: Iterable[Behaviour], memory: bool = True):
        composites.Selector.__init__(self, face.name, memory, list(children))
        self.take(face)
