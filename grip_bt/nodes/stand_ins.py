"""Stand-ins for what isn't here: packages that aren't installed, arguments that nobody has given.

They accept every call, attribute and operation, and do nothing. What the code then asks of them (`if`, `==`, `for`) is
answered by a `Judge`, which can note it, or answer contrarily. A stand-in may hold a value, such as the default of a
parameter: then it answers as the value would, and the judge is told that the answer hangs on it.
"""

from __future__ import annotations

import dis
import operator
import sys
from collections.abc import Callable, Collection, Generator, Iterator
from functools import partialmethod
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import FunctionType, ModuleType
from typing import Any

from grip_bt.smach_compat.smach_ros._connection import wanted_names

UNKNOWN: Any = object()
"""What a stand-in holds that holds no value."""

_LONGEST = 60
_STORING = frozenset(
    ("BUILD_MAP", "BUILD_CONST_KEY_MAP", "BUILD_SET", "STORE_SUBSCR", "MAP_ADD", "SET_ADD", "DELETE_SUBSCR")
)


class Judge:
    """Answers what code asks of stand-ins: this one obligingly, and keeps nothing.

    Attributes:
        elsewhere: whether it gave an answer that isn't true of what stand-ins hold.
        used: whether anything has gone by a stand-in.
        known: what somebody has said of things that aren't here, by their names: their values, answers to questions.
        lasting: what was decided of what stays as it is while a machine is built: parameters, classes, orders of sets.
    """

    elsewhere = used = False

    def __init__(self) -> None:
        self.lasting: dict[Any, Any] = {}
        self.known: dict[str, Any] = {}

    def decide(self, what: str, wanted: bool) -> bool:
        """Return the answer to a question with two answers; `wanted` is the one that leads on, most often."""
        self.used = True
        return wanted

    def lacks(self, what: str, also: str = "") -> bool:
        """Tell whether a name isn't there, for code that is prepared for that; `also`: errors that are taken for it."""
        return False

    def note(self, what: str, value: object = UNKNOWN) -> None:
        """Take note that code goes by what stands in: by a value that it holds, or by one that nobody knows."""
        self.used = True


judge = Judge()


def judged_by(new: Judge) -> None:
    """Have another judge, in the whole process."""
    global judge
    judge = new


def asked_once(value: Any, what: str, wanted: bool, *about: object) -> bool:
    """Return the answer to a question about a stand-in, which stays as it is; `about`: what else is in it.

    Without a question it is asked whether it is true.
    """
    answers = vars(value).setdefault("_stand_in_answers", {})
    key = (what, *map(id, about))
    if key not in answers:
        answers[key] = judge.decide(what or name_of(value), wanted), about  # which lives on, and so keeps its id
    return bool(answers[key][0])


def _is_class(name: str) -> bool:
    return name[:1].isupper() and not name.isupper()


class _Kind(type):
    """Makes every attribute of a stand-in class a stand-in too."""

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        made = stand_in_class(name) if _is_class(name) else stand_in(f"{cls.__name__}.{name}")
        setattr(cls, name, made)
        return made

    def __instancecheck__(cls, instance: object) -> bool:
        if type.__instancecheck__(cls, instance) or cls is StandIn or not type.__instancecheck__(StandIn, instance):
            return type.__instancecheck__(cls, instance)
        what = f"isinstance({name_of(instance)}, {cls.__name__})"
        made_by = type(instance)
        if made_by is StandIn:
            return asked_once(instance, what, True, cls)
        if (cls, made_by) not in judge.lasting:  # it holds for all that this class makes
            judge.lasting[cls, made_by] = judge.decide(what, True)
        return bool(judge.lasting[cls, made_by])

    def __eq__(cls, other: object) -> bool:
        if cls is other or not isinstance(other, _Kind):
            return cls is other or NotImplemented
        if cls.__name__ != other.__name__:
            return False
        both = frozenset(map(id, (cls, other)))  # a class may be had by more than one name
        if both not in judge.lasting:
            judge.lasting[both] = judge.decide(f"the classes {cls.__name__} are one", True)
        return bool(judge.lasting[both])

    def __hash__(cls) -> int:
        return hash(cls.__name__)

    def __iter__(cls) -> Iterator[Any]:
        judge.note(cls.__name__)
        return iter(())

    def __getitem__(cls, key: object) -> Any:
        return cls


class StandIn(metaclass=_Kind):
    """Accepts every call, attribute and operation."""

    _stand_in_name = _stand_in_called = ""
    _stand_in_held: Any = UNKNOWN
    _stand_in_wanted = True
    _stand_in_class: Any = None

    def __init__(self, *arguments: object, **named: object):
        """Take anything; a text may be what it is called, as a node of a tree is."""
        called = named.get("name", next((each for each in arguments if isinstance(each, str)), ""))
        vars(self)["_stand_in_called"] = called if isinstance(called, str) else ""

    def __call__(self, *arguments: object, **named: object) -> Any:
        """Return a stand-in; as a decorator, what is decorated."""
        if held_by(self) is not UNKNOWN:
            return lifted(held_by(self), name_of(self), *arguments, **named)
        if len(arguments) == 1 and not named and isinstance(arguments[0], (FunctionType, type)):
            return arguments[0]
        made = known(f"{name_of(self)}()")
        if isinstance(made, StandIn):
            StandIn.__init__(made, *arguments, **named)
        return made

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        held = held_by(self)
        if held is not UNKNOWN:
            return stand_in(name_of(self), getattr(held, name))
        made = known(f"{name_of(self)}.{name}")
        vars(self)[name] = made
        return made

    def __mro_entries__(self, bases: tuple[Any, ...]) -> tuple[type, ...]:
        return (stand_in_class(name_of(self).split(".")[-1]),)

    def __getitem__(self, key: object) -> Any:
        held = held_by(self)
        return self._made(operator.getitem, key) if held is not UNKNOWN else known(f"{name_of(self)}[{key!r}]")

    def __setitem__(self, key: object, value: object) -> None:
        if held_by(self) is not UNKNOWN:
            held_by(self)[key] = value

    def __iter__(self) -> Iterator[Any]:
        frame, held, name = sys._getframe(1), held_by(self), name_of(self)
        code = frame.f_code.co_code
        if dis.opname[code[frame.f_lasti]] == "UNPACK_SEQUENCE":
            wanted = code[frame.f_lasti + 1]
            if held is UNKNOWN or (isinstance(held, (list, tuple)) and len(held) == wanted):
                return iter([self[number] for number in range(wanted)])
        judge.note(name, held)
        return iter(()) if held is UNKNOWN else iter([stand_in(name, item) for item in held])

    def __bool__(self) -> bool:
        held = held_by(self)
        return asked_once(self, "", self._stand_in_wanted if held is UNKNOWN else bool(held))

    def _forced(self, kind: Callable[[Any], Any], otherwise: Any) -> Any:
        held = held_by(self)
        judge.note(name_of(self), held)
        return otherwise if held is UNKNOWN else kind(held)

    def __array__(self, *given: object, **named: object) -> Any:
        """Return it as an array of NumPy, which is what asks for one."""
        return sys.modules["numpy"].array(self._forced(lambda held: held, 0.0), *given, **named)

    def __str__(self) -> str:
        return str(self._forced(str, f"<{name_of(self)}>"))

    __fspath__ = __str__

    def __format__(self, spec: str) -> str:
        return str(self._forced(lambda held: format(held, spec), f"<{name_of(self)}>"))

    def __repr__(self) -> str:
        return f"<{name_of(self)}>"

    def __hash__(self) -> int:
        frame = sys._getframe(1)
        if dis.opname[frame.f_code.co_code[frame.f_lasti]] not in _STORING:
            judge.note(name_of(self), held_by(self))
        return 0 if held_by(self) is UNKNOWN else hash(held_by(self))

    def __contains__(self, item: object) -> bool:
        held = held_by(self)
        wanted = held is not UNKNOWN and value_of(item) in held
        return judge.decide(f"{item!r} in {name_of(self)}", wanted)

    def __enter__(self) -> Any:
        return self

    def __exit__(self, *given: object) -> None:
        pass

    def __await__(self) -> Generator[Any, None, Any]:
        yield from ()
        return self

    def _made(self, work: Callable[..., Any], *others: object) -> Any:
        return lifted(work, name_of(self), self, *others)

    def _asked(self, work: Callable[..., Any], sign: str, other: object) -> Any:
        if other is None and sign in ("==", "!=") and type(self) is not StandIn:  # it was made by calling a class
            return sign == "!="
        name = f"{name_of(self)} {sign} {other!r}"
        if held_by(self) is not UNKNOWN and value_of(other) is not UNKNOWN:
            return stand_in(name_of(self), work(held_by(self), value_of(other)))
        kind = self._stand_in_class
        if sign in ("==", "!=") and kind in (str, list, dict, tuple) and not isinstance(other, kind):
            return sign == "!="
        items = other if type(other) is list else [other]
        if not all(isinstance(item, (str, int, float, type, type(None))) for item in items):
            return stand_in(name, wanted=sign == "!=")
        compared = vars(self).setdefault("_stand_in_compared", {})
        asked = (type(other) is list, *((type(item), item) for item in items))
        equal = _implied(compared, asked) if sign in ("==", "!=") else None
        if equal is not None:
            return equal == (sign == "==")
        return compared.setdefault((sign, asked), stand_in(name, wanted=sign == "!="))


def _implied(compared: dict[tuple[str, tuple[Any, ...]], StandIn], asked: tuple[Any, ...]) -> bool | None:
    """Return whether something is equal to what is asked about, if the answers to earlier questions say so."""
    for (sign, before), made in compared.items():
        said = vars(made).get("_stand_in_answers", {}).get(("",))
        if said is None or sign not in ("==", "!="):
            continue
        equal = bool(said[0]) == (sign == "==")
        if before == asked:
            return equal
        maybe_same = all(any(kind is _Kind for kind, _ in each[1:]) for each in (before, asked))  # names of one class
        if equal and (before[0] != asked[0] or not maybe_same):
            return before[0] == asked[0] and [each for _, each in before[1:]] == [each for _, each in asked[1:]]
    return None


def _turned(work: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    return lambda one, other: work(other, one)


for _name in "add sub mul truediv floordiv mod pow or and xor lshift rshift matmul".split():
    _work = getattr(operator, f"__{_name}__")
    setattr(StandIn, f"__{_name}__", partialmethod(StandIn._made, _work))
    setattr(StandIn, f"__r{_name}__", partialmethod(StandIn._made, _turned(_work)))
for _name, _work in (*((n, getattr(operator, n)) for n in ("neg", "pos", "abs", "invert")), ("round", round)):
    setattr(StandIn, f"__{_name}__", partialmethod(StandIn._made, _work))
for _name, _kind in (("float", float), ("int", int), ("index", operator.index), ("len", len)):
    setattr(StandIn, f"__{_name}__", partialmethod(StandIn._forced, _kind, 0.0 if _kind is float else 0))
for _name, _sign in (("eq", "=="), ("ne", "!="), ("lt", "<"), ("le", "<="), ("gt", ">"), ("ge", ">=")):
    setattr(StandIn, f"__{_name}__", partialmethod(StandIn._asked, getattr(operator, _name), _sign))


def stand_in(name: str, held: Any = UNKNOWN, wanted: bool = True) -> StandIn:
    """Return a stand-in that people know by this name; `wanted`: what `if` is told."""
    made = StandIn()
    vars(made).update(_stand_in_name=name[:_LONGEST], _stand_in_held=held, _stand_in_wanted=wanted)
    return made


def known(name: str, held: Any = UNKNOWN) -> Any:
    """Return what somebody has said of something of this name, or a stand-in."""
    return judge.known[name[:_LONGEST]] if name[:_LONGEST] in judge.known else stand_in(name, held)


def lasting(name: str, held: Any, there: bool) -> Any:
    """Return what is `known`, the same one each time; `there`: whether it can't be None."""
    made = surely(object if there else None, known(name, held))
    # What isn't plain may be changed where it is used, so each place has its own.
    plain = held is UNKNOWN or isinstance(held, (str, int, float, type(None)))
    return judge.lasting.setdefault((name, there, type(held), held), made) if plain else made


def surely(kind: type | None, value: Any) -> Any:
    """Return a value; if it stands in, it is known to be of a class, `object` for any but None."""
    if stands_in(value):
        vars(value)["_stand_in_class"] = kind
    return value


def stands_in(value: object) -> bool:
    """Tell whether a value is a stand-in, or of a class that derives from one."""
    return issubclass(type(value), StandIn)


def name_of(value: object) -> str:
    """Return what people know a stand-in by."""
    return getattr(value, "_stand_in_name", "") or type(value).__name__


def held_by(value: object) -> Any:
    """Return the value that a stand-in holds, or UNKNOWN."""
    return value._stand_in_held if isinstance(value, StandIn) else value


def value_of(value: object) -> Any:
    """Return a value, or that of a stand-in; lists and dictionaries with what is in them, UNKNOWN where one is."""
    if stands_in(value):
        return held_by(value)
    if type(value) in (list, tuple):
        items = [value_of(item) for item in value]  # type: ignore[attr-defined]
        return UNKNOWN if any(item is UNKNOWN for item in items) else type(value)(items)  # type: ignore[call-arg]
    if type(value) is dict:
        keys = {value_of(key): value_of(item) for key, item in value.items()}
        return UNKNOWN if any(each is UNKNOWN for pair in keys.items() for each in pair) else keys
    return value


def unwrapped(value: Any, told: Callable[[str, Any], object] = lambda name, held: None) -> Any:
    """Return a label, or a list or mapping of them, without stand-ins; `told` hears of each, and of what it holds."""
    if stands_in(value) and not isinstance(value, type):
        held = value_of(value)
        told(name_of(value), held)
        return f"<{name_of(value)}>" if held is UNKNOWN else held
    if isinstance(value, (list, tuple)):
        return [unwrapped(each, told) for each in value]
    if isinstance(value, dict) and any(stands_in(each) for pair in value.items() for each in pair):
        return {unwrapped(key, told): unwrapped(each, told) for key, each in value.items()}
    return value


def lifted(work: Callable[..., Any], name: str, *arguments: object, **named: object) -> Any:
    """Return what a function makes of stand-ins: one that holds the result, or one that nobody knows."""
    given = [value_of(each) for each in arguments]
    by_name = {key: value_of(each) for key, each in named.items()}
    if any(each is UNKNOWN for each in (*given, *by_name.values())):
        return stand_in(name)
    try:
        return stand_in(name, work(*given, **by_name))
    except Exception:
        if judge.elsewhere:  # where that answer is true, something else is held
            return stand_in(name)
        judge.note(name, next((v for each, v in zip(arguments, given, strict=True) if stands_in(each)), UNKNOWN))
        raise


def stand_in_class(name: str) -> type:
    """Return a new class of stand-ins; it may be called, derived from, and raised where it is called an error."""
    raised = name.endswith(("Error", "Exception", "Interrupt"))
    return _Kind(name, (StandIn, Exception) if raised else (StandIn,), {"__module__": "stand_in"})


class StandInModule(ModuleType):
    """A module of which every name is a stand-in."""

    __path__: list[str] = []
    _stand_in_lacks: Collection[str] = ()

    def __getattr__(self, name: str) -> Any:
        if name == "__all__":
            return sorted(wanted_names(sys._getframe(1)))
        there = not name.startswith("__") and name not in self._stand_in_lacks
        if there and judge.lacks(f"{self.__name__}.{name} is there"):
            self._stand_in_lacks, there = {*self._stand_in_lacks, name}, False
        if not there:
            raise AttributeError(name)
        made = stand_in_class(name) if _is_class(name) else known(f"{self.__name__}.{name}")
        setattr(self, name, made)
        return made


def is_generated(name: str) -> bool:
    """Tell whether a module is one that the build of a ROS package makes of its messages."""
    return name.partition(".")[2].split(".")[0] in ("msg", "srv", "action", "cfg")


def asked_by_a_library() -> bool:
    """Tell whether an installed library imports something, which it can do without."""
    frame = sys._getframe(1)
    while frame.f_back is not None and (frame.f_code.co_name == "find_spec" or "importlib" in frame.f_code.co_filename):
        frame = frame.f_back
    return "-packages" in frame.f_code.co_filename and "grip_bt" not in frame.f_code.co_filename


class StandInFinder(MetaPathFinder, Loader):
    """Comes last: what no other finder has is a stand-in; knows the packages that it stood in for.

    Attributes:
        packages: their names, in the order of their imports.
        made: module -> what gives it names of its own.
        certain: those that are taken for installed, which code may be prepared for not to be.
        parts: whether it stands in for what a package lacks that isn't installed but lies here, too.
    """

    parts = False

    def __init__(self, certain: Collection[str] = ()) -> None:
        self.packages, self.certain = list[str](), certain
        self.made: dict[str, Callable[[ModuleType], object]] = {}

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        """Find every module that isn't part of Python or of an installed package.

        Messages of a package whose sources are here, and which wasn't built, are found too.
        """
        package = fullname.split(".")[0]
        there = sys.modules.get(package)
        installed = any("-packages" in folder for folder in getattr(there, "__path__", ()))
        older = self.parts and package.endswith("_msgs") and not is_generated(fullname)  # ROS 1 had more in it
        of_sources = older or ((self.parts or is_generated(fullname)) and not installed)
        real = there is not None and not isinstance(there, StandInModule) and not of_sources
        above, _, last = fullname.rpartition(".")
        lacking = last in getattr(sys.modules.get(above), "_stand_in_lacks", ())
        if package in sys.stdlib_module_names or real or lacking or asked_by_a_library():
            return None
        if package not in self.packages:
            self.packages.append(package)
        if package not in self.certain and judge.lacks(f"import {fullname}", "|(Base)?Exception"):
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)
        return ModuleSpec(fullname, self, is_package=True)

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = StandInModule(spec.name)
        if spec.name in self.made:
            self.made[spec.name](module)
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: names are made when somebody asks for them."""


def are_wanted() -> bool:
    """Tell whether this process has stand-ins for what is missing now."""
    return any(isinstance(finder, StandInFinder) for finder in sys.meta_path)
