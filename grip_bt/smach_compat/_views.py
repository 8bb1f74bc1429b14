"""The views that the states of one machine get of its userdata, made once and used again while nothing has changed.

Upstream makes a `Remapper` for each activation of a state; that was a third of the time of a transition.
"""

from __future__ import annotations

from typing import Any

from . import _quick_view
from ._names import Names
from .state import State
from .user_data import Remapper, UserData

_GETTERS = {
    name: getattr(State, name)
    for name in ("get_registered_outcomes", "get_registered_input_keys", "get_registered_output_keys")
}
TRIALS = 8
"""Activations of a state, at least, from one making of a view to the next, which takes as long as a few transitions."""


Row = tuple[State, Remapper, dict[str, Any], frozenset[str], frozenset[str], Any, UserData]
"""A plain state and its view; what was left on the view (its very `__dict__`); and all that it was made from: input
keys, output keys, remapping and store. An ordinary tuple is unpacked at once, others item by item."""


class Views:
    """Label -> view.

    Attributes:
        rows: those of this execution, whose states are plain: they answer from their sets, as `State` does.
    """

    def __init__(self) -> None:
        self.rows: dict[Any, Row] = {}
        self._earlier: dict[Any, Row] = {}
        self._missed: dict[Any, int] = {}  # label -> activations without a view that could be used again

    def begin(self) -> None:
        """Begin an execution: what states are has to be seen anew."""
        self._earlier.update(self.rows)
        self.rows.clear()
        if self._earlier and not _quick_view.untouched():
            self._earlier.clear()

    def get(self, label: Any, state: Any, ud: Any, remapping: Any) -> tuple[Remapper, bool]:
        """Return a state's view, and whether the state's own sets say what it has registered."""
        row = self.row(label, state, ud, remapping)
        if row is not None:
            return row[1], True
        view = Remapper(ud, state.get_registered_input_keys(), state.get_registered_output_keys(), remapping)
        return view, _is_plain(state)

    def row(self, label: Any, state: Any, ud: Any, remapping: Any) -> Row | None:
        """Return a plain state's row, or None where nothing is to be used again.

        The last view is used again only if all that it was made from is the same and nobody has left an attribute
        on it: a state can't tell it from a new one. Only a state that comes again gets one.
        """
        row = self.rows.get(label)
        if row is not None and _fits(row, state, ud, remapping):
            known, view, left, _, _, names, store = row
            keys = _frozen(state._input_keys), _frozen(state._output_keys)
            row = self.rows[label] = (known, view, left, *keys, names, store)
            return row
        if not _is_plain(state):
            return None
        row = self._earlier.pop(label, None)
        if row is None or not _fits(row, state, ud, remapping):
            missed = self._missed[label] = self._missed.get(label, 0) + 1
            if missed % TRIALS != 2:
                return None
            row = _made(state, ud, remapping)
        self.rows[label] = row
        return row

    def __reduce__(self) -> tuple[Any, ...]:
        return (Views, ())  # a copied machine makes its own


def _fits(row: Row, state: Any, ud: Any, remapping: Any) -> bool:
    """Tell whether a view made anew would be the same."""
    known, _, left, inputs, outputs, names, store = row
    return (
        known is state
        and _frozen(state._input_keys) == inputs
        and _frozen(state._output_keys) == outputs
        and names is remapping
        and store is ud
        and not left
    )


def _made(state: State, ud: Any, remapping: Any) -> Row:
    make = _quick_view.quick_view if _quick_view.possible(ud) else Remapper
    inputs, outputs = _frozen(state._input_keys), _frozen(state._output_keys)
    view = make(ud, inputs, outputs, remapping)
    return state, view, view.__dict__, inputs, outputs, remapping, ud


def _frozen(keys: set[str]) -> frozenset[str]:
    return keys.freeze() if isinstance(keys, Names) else frozenset(keys)


def _is_plain(state: Any) -> bool:
    """Tell whether a state answers the container's questions from its sets, as `State` does."""
    # By the bound methods and not by `vars(state)`: asking for that makes each access to the state slower from then on.
    return isinstance(state, State) and all(
        getattr(getattr(state, name), "__func__", None) is own for name, own in _GETTERS.items()
    )
