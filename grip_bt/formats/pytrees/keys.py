"""What behaviours have on py_trees' blackboard, and the variables of a task that stand for its keys."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard, Client
from py_trees.common import Status

from grip_bt.base.errors import ExpressionError
from grip_bt.base.expression import CONSTANTS, parse_expression
from grip_bt.formats.names import free, is_literal


class NoEquivalentError(Exception):
    """A behaviour has no equivalent in a task; the text says why."""


class Keys:
    """Hands out a variable for each key of the blackboard that is asked for; `names`: `/namespace/key` -> variable.

    `kept`: keys that behaviours see which stay as they are; a Status under any other key can be a text.

    Raises:
        NoEquivalentError: from every method, where a behaviour does more than a task can say.
    """

    def __init__(self) -> None:
        self.names: dict[str, str] = {}
        self.kept: set[str] = set()

    def variable(self, key: str) -> str:
        """Return the variable of a key."""
        if key not in self.names:
            name = re.sub(r"\W+", "_", key.strip("/"), flags=re.ASCII).lstrip("0123456789") or "key"
            self.names[key] = free(f"{name}_" if name in CONSTANTS else name, [*self.names.values()])
        return self.names[key]

    def plain(self, client: Client, name: str) -> str:
        """Return the variable of a key as a behaviour names it."""
        if "." in name:
            raise NoEquivalentError(f"{name} is an attribute of what is on the blackboard")
        return self.variable(stored(client, client.absolute_name(name)))

    def literal(self, generator: Any, client: Client, name: str) -> Any:
        """Return the value that py_trees was given for a key; it makes functions of them."""
        value = generator() if getattr(generator, "__module__", "").startswith("py_trees.") else generator
        if isinstance(value, Status) and stored(client, client.absolute_name(name)) not in self.kept:
            return str(value)
        if not is_literal(value):
            raise NoEquivalentError("it takes what a Python function returns, or an object")
        return value

    def condition(self, function: Any, client: Client) -> str:
        """Return the expression that a condition over the blackboard is."""
        try:
            body = _returned(getattr(function, "func", function))
            text = ast.unparse(_Renamed(self, client).visit(body))
            return parse_expression(text).text
        except (OSError, AttributeError, SyntaxError, ValueError, ExpressionError) as error:
            raise NoEquivalentError("its condition is a Python function that does more than compare keys") from error

    def initial(self) -> dict[str, dict[str, Any]]:
        """Return what a task declares: what is on the blackboard now, as far as a document can hold it."""
        there = {key: Blackboard.storage.get(key) for key in self.names}
        return {self.names[key]: {"type": "Any", "value": v if is_literal(v) else None} for key, v in there.items()}


class NoKeys(Keys):
    """For what is read without its blackboard."""

    def variable(self, key: str) -> str:
        """Refuse."""
        raise NoEquivalentError("it works on py_trees' blackboard, which a task hasn't; its variables have types")


def stored(client: Client, key: str) -> str:
    """Return the key under which the blackboard has what a client calls `/key`."""
    return str(client.remappings.get(key, key))


def keys_of(behaviour: Behaviour, remapped: bool = False) -> tuple[dict[str, str], dict[str, str]]:
    """Return what a behaviour reads and writes: how it is called -> key of the blackboard.

    Args:
        remapped: whether keys are called as the behaviour calls them; else as the blackboard does.
    """
    reads, writes = dict[str, str](), dict[str, str]()
    held = [value for value in vars(behaviour).values() if isinstance(value, Client)]
    for client in {id(each): each for each in (*behaviour.blackboards, *held)}.values():
        for found, registered in ((reads, client.read), (writes, client.write), (writes, client.exclusive)):
            found |= {(key if remapped else stored(client, key)): stored(client, key) for key in sorted(registered)}
    return reads, writes


def _returned(function: Any) -> ast.expr:
    """Return the expression that a function returns, where it does nothing else."""
    code = function.__code__
    arguments = list(code.co_varnames[: code.co_argcount])
    found = [
        node
        for node in ast.walk(ast.parse(Path(code.co_filename).read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef | ast.Lambda)
        and node.lineno == code.co_firstlineno
        and [each.arg for each in node.args.args] == arguments
    ]
    if len(found) != 1:
        raise ValueError("which function it is isn't known")
    if isinstance(found[0], ast.Lambda):
        return found[0].body
    body = [each for each in found[0].body if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))]
    if len(body) != 1 or not isinstance(body[0], ast.Return) or body[0].value is None:
        raise ValueError("it does more than return")
    return body[0].value


class _Renamed(ast.NodeTransformer):
    """Puts variables in place of keys: of `blackboard.key`, and of nothing else."""

    def __init__(self, keys: Keys, client: Client):
        self._keys, self._client = keys, client

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        if isinstance(node.value, ast.Name) and node.value.id == "blackboard":
            return ast.Name(self._keys.plain(self._client, node.attr), ast.Load())
        raise ValueError("an attribute of something else")

    def visit_Name(self, node: ast.Name) -> ast.AST:
        raise ValueError(f"{node.id} isn't on the blackboard")
