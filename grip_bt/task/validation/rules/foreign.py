"""Behaviours that a task names by their import path: may they be imported, and are they there. Nothing is imported."""

from __future__ import annotations

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Foreign
from grip_bt.task.catalog import AllowedImports
from grip_bt.task.catalog.project_parts import MISSING, Trouble

from ..survey import Survey
from ..wording import take_hint


def check_foreign(survey: Survey) -> None:
    """Find behaviours that the project doesn't list, and those that their module doesn't have."""
    code = survey.catalog.code
    for spot in survey.containers:
        if not isinstance(spot.node, Foreign):
            continue
        where = spot.node.behaviour
        trouble = _missing(survey, where) if code.allows(where) else not_listed(where, code.listed)
        if trouble is not None:
            survey.add(spot.path, "behaviour", trouble.code, trouble.message, trouble.fix)


def not_listed(where: str, listed: tuple[str, ...]) -> Trouble:
    """Return that a task may not import `package.module:Name`, since it isn't what its project lists."""
    hint = nearest(where, listed) or nearest(where.partition(":")[0], listed)
    there = f" (it lists: {listing(listed)})" if listed else ""
    said = f"{where!r} is no code that the project lets its tasks import{hint}{there}"
    otherwise = f"if you trust it, list it in grip.yaml: `code: [{where!r}]`"
    return Trouble("unlisted-code", said, take_hint(hint, otherwise))


def _missing(survey: Survey, where: str) -> Trouble | None:
    """Return that a module isn't here or lacks a name, as far as its source tells."""
    module, _, name = where.partition(":")
    code = survey.catalog.code
    try:
        known = code.names_in(module)
    except ModuleNotFoundError as error:
        return Trouble(MISSING, f"{error}, which a run imports", "install its package, or correct the path")
    first = name.partition(".")[0]
    if known is None or first in known:
        return _no_class(code, where)
    public = sorted(each for each in known if not each.startswith("_"))
    hint = nearest(first, public)
    return Trouble("unknown-behaviour", f"the module {module} has no {first!r}{hint}", take_hint(hint, "correct it"))


def _no_class(code: AllowedImports, where: str) -> Trouble | None:
    """Return that what a task names isn't a class, where its source tells; a function has to be listed by its name."""
    kind = code.kind_of(where)
    if kind is None or kind == "class" or code.names(where):
        return None
    if not code.is_third_party(where):
        return Trouble("unknown-behaviour", f"{where!r} is no behaviour of py_trees", "name one of its classes")
    said = f"{where!r} is a function, which is called only if the project lists it by its name"
    return Trouble("unknown-behaviour", said, f"if you trust it, list it in grip.yaml: `code: [{where!r}]`")
