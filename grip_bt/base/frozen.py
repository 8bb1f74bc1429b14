"""A dict that can't be changed, so that task graphs and robots are values: safe to share, to compare, to keep."""

from __future__ import annotations

from copy import deepcopy
from types import GenericAlias
from typing import Any, NoReturn, TypeVar

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema

K = TypeVar("K")
V = TypeVar("V")


class FrozenDict(dict[K, V]):
    """An ordered mapping whose methods that would change it raise TypeError; pydantic fields may be of this type."""

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("this mapping is a value and can't be changed; make a new one")

    __setitem__ = __delitem__ = clear = pop = popitem = setdefault = update = __ior__ = _refuse

    def __reduce__(self) -> Any:
        return (type(self), (dict(self),))

    def __deepcopy__(self, memo: dict[int, object]) -> FrozenDict[K, V]:
        # pydantic copies an unhashable default for every model; an empty one that can't change serves them all
        return FrozenDict({k: deepcopy(v, memo) for k, v in self.items()}) if self else self

    @classmethod
    def __get_pydantic_core_schema__(cls, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        arguments = getattr(source, "__args__", (Any, Any))
        inner = handler.generate_schema(GenericAlias(dict, arguments))
        return core_schema.no_info_after_validator_function(cls, inner)
