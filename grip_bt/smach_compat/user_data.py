"""Userdata: the store of a container, and the view of it that one state gets."""

from __future__ import annotations

import copy
import threading
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from grip_bt.smach_compat._settings import hooks

from .exceptions import InvalidUserCodeError

NOTHING: list[Any] = []
"""The default of list arguments. A list and not a tuple, because callers' lists are added to it; never written."""


Remapping = Mapping[str, str] | Collection[str]
"""The state's key -> the container's key; smach_ros passes an empty list for none."""


class _Locks(dict[str, threading.Lock]):
    """The locks of keys, made for who asks. Where nobody did there is nothing to wait for: a dict needs no lock."""

    def __missing__(self, key: str) -> threading.Lock:
        return self.setdefault(key, threading.Lock())


class UserData:
    """The variables of a container, as attributes and as items.

    Names that begin with an underscore are attributes of the object and no data. A missing name raises KeyError,
    for attributes too: `hasattr` doesn't work on it. Who holds `_locks[name]` keeps others from the attribute.
    """

    def __init__(self) -> None:
        self._data: dict[str, Any] = {}
        self._locks: dict[str, threading.Lock] = _Locks()

    def __getattr__(self, name: str) -> Any:
        if name[0] == "_":
            raise AttributeError(f"userdata has no attribute {name!r}")
        try:
            if name in self._locks:
                with self._locks[name]:
                    return self._data[name]
            return self._data[name]
        except KeyError:
            hooks.logerr(f"Userdata key {name!r} not available; available keys are: {self.keys()}")
        raise KeyError()

    __getitem__ = __getattr__

    def __setattr__(self, name: str, value: object) -> None:
        if name[0] == "_":
            object.__setattr__(self, name, value)
        elif name in self._locks:
            with self._locks[name]:
                self._data[name] = value
        else:
            self._data[name] = value

    def __setitem__(self, key: str, value: object) -> None:
        self._data[key] = value

    def __contains__(self, key: object) -> bool:
        return key in self._data

    def keys(self) -> list[str]:
        """Return the names that have a value."""
        return list(self._data)

    def update(self, ud: UserData) -> None:
        """Take over all values of another store."""
        self._data.update(ud._data)

    def extract(self, keys: Iterable[str], remapping: dict[str, str]) -> UserData:
        """Return a new store with shallow copies of `keys`, renamed back: from what `remapping` maps *to*."""
        names = {there: here for here, there in remapping.items()}
        result = UserData()
        for key in keys:
            result[names.get(key, key)] = copy.copy(self[key])
        return result

    def merge(self, ud: UserData, keys: Iterable[str], remapping: dict[str, str]) -> None:
        """Take over shallow copies of `keys` of another store, renamed by `remapping`."""
        for key in keys:
            self[remapping.get(key, key)] = copy.copy(ud[key])

    def __getstate__(self) -> dict[str, Any]:
        return {k: v for k, v in self.__dict__.items() if k != "_locks"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, _locks=_Locks())


class Const:
    """A value that a state may only read: what is read from it is wrapped in the same way.

    Setting an attribute changes the wrapper and not the value. Methods can't be called.
    """

    def __init__(self, obj: Any):
        self._obj = obj

    def __getattr__(self, name: str) -> Any:
        if name == "_obj":  # asked for before __init__, when a copy or a pickle is rebuilt
            raise AttributeError(name)
        return get_const(getattr(self._obj, name))

    def __getitem__(self, name: Any) -> Any:
        return get_const(self._obj[name])

    def __delattr__(self, name: str) -> None:
        hooks.logerr(f"Attempt to delete {name!r} of a value that is an input only.")
        raise TypeError(f"can't delete {name!r}: the value is an input only")


def get_const(obj: object) -> Any:
    """Return the value wrapped for reading, or itself when it has no attributes of its own (no `__dict__`)."""
    return Const(obj) if hasattr(obj, "__dict__") else obj


class Remapper:
    """What one state sees of its container's userdata: declared keys only, under the state's names.

    Reading an undeclared key raises InvalidUserCodeError; writing one is logged and ignored.

    Args:
        output_keys: names that may be written; one that is in both gives the value itself, not a `Const`.
        remapping: the state's name -> the container's name, for names that differ.
    """

    def __init__(
        self,
        ud: Any,
        input_keys: Iterable[str] = NOTHING,
        output_keys: Iterable[str] = NOTHING,
        remapping: Remapping = NOTHING,
    ):
        vars(self).update(_ud=ud, _input=tuple(input_keys), _output=tuple(output_keys), _map=remapping)

    def __getattr__(self, name: str) -> Any:
        if name[0] == "_":
            raise AttributeError(f"userdata has no attribute {name!r}")
        return self[name]

    def __setattr__(self, name: str, value: object) -> None:
        if name[0] == "_":
            object.__setattr__(self, name, value)
        else:
            self[name] = value

    def __getitem__(self, key: str) -> Any:
        if key not in self._input:
            raise InvalidUserCodeError(
                f"Reading userdata key {key!r}, but the declared inputs of this state are: {sorted(self._input)}"
            )
        value = self._ud[self._remap(key)]
        return value if key in self._output else get_const(value)

    def __setitem__(self, key: str, value: object) -> None:
        if key not in self._output:
            hooks.logerr(
                f"Writing userdata key {key!r}, but the declared outputs of this state are: {sorted(self._output)}"
            )
            return
        self._ud[self._remap(key)] = value

    def __contains__(self, key: object) -> bool:
        return key in self._input and self._remap(key) in self._ud

    def _remap(self, key: object) -> Any:
        return self._map[key] if key in self._map else key

    def keys(self) -> list[str]:
        """Return the container's names of those of its keys that are inputs under the same name."""
        return [self._remap(key) for key in self._ud.keys() if key in self._input]

    def update(self, ud: UserData) -> None:
        """Take over all values of another store, declared or not."""
        self._ud.update(ud)
