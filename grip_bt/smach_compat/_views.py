"""The views that the states of one machine get of its userdata, made once and used again while nothing has changed.

Upstream makes a `Remapper` for each activation of a state; that was a third of the time of a transition.
"""

from __future__ import annotations

from typing import Any

from .state import State
from .user_data import Remapper

_GETTERS = ("get_registered_outcomes", "get_registered_input_keys", "get_registered_output_keys")


class Views:
    """Label -> view."""

    def __init__(self) -> None:
        # label -> (state, input keys, output keys, remapping, userdata, the view made from these); of plain states only
        self._made: dict[Any, tuple[Any, ...]] = {}

    def clear(self) -> None:
        """Forget all views."""
        self._made.clear()

    def get(self, label: Any, state: Any, ud: Any, remapping: Any) -> tuple[Remapper, bool]:
        """Return a state's view, and whether the state's own sets say what it has registered.

        The last view is used again only if all that it was made from is the same and nobody has left an attribute
        on it: a state can't tell it from a new one.
        """
        try:
            known, inputs, outputs, names, store, view = self._made[label]
        except KeyError:
            known = None
        if (
            known is state
            and inputs == state._input_keys
            and outputs == state._output_keys
            and names is remapping
            and store is ud
            and not view.__dict__
        ):
            return view, True
        view = Remapper(ud, state.get_registered_input_keys(), state.get_registered_output_keys(), remapping)
        plain = _is_plain(state)
        if plain:
            self._made[label] = (state, view._input, view._output, remapping, ud, view)
        return view, plain

    def __reduce__(self) -> tuple[Any, ...]:
        return (Views, ())  # a copied machine makes its own


def _is_plain(state: Any) -> bool:
    """Tell whether a state answers the container's questions from its sets, as `State` does."""
    return isinstance(state, State) and all(
        getattr(type(state), name) is getattr(State, name) and name not in state.__dict__ for name in _GETTERS
    )
