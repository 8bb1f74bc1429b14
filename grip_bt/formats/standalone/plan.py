"""What a file needs, gathered while its tree is written."""

from __future__ import annotations

from dataclasses import dataclass, field

from grip_bt.compilers.resolve import Part, Resolved
from grip_bt.formats.names import Identifiers
from grip_bt.task import model
from grip_bt.task.kinds.base import every_kind

from .kind_source import NAMES, KindSource

ORDER = (
    *("variable", "bind", "labels", "scope", "precondition", "same", "kinds", "container"),
    *("fail", "log", "foreign"),
)
"""Supporting parts, in the order in which the file has them."""
_OWN_NAMES = (
    *("py_trees", "Status", "Any", "Callable", "Iterator", "Mapping", "NamedTuple", "copy", "time", "logging"),
    *("Variable", "Scope", "Precondition", "Fail", "Log", "Foreign", "Real", "is_truth", "same"),
    *("bind", "outcome_of", "code_of", "carried_code", "look_up", "create_root", "end_of", "run", "ENDS"),
    *("Leaf", "Context", "RunContext", "Catalog", "Manifest", "load_implementation", "NODES", "Path", "HERE"),
    *(kind.__name__ for kind in every_kind()),
    *NAMES,
)


@dataclass
class Plan:
    """The file under construction.

    Attributes:
        grip: whether a leaf needs grip.
        codes: whether an edge asks for the code of a failure.
        identifiers: names that are free.
        parts: names of the supporting parts that are used.
        kinds: those whose own source is used.
        imports: module -> class -> its name in the file.
        builtin: whether manifests of nodes that come with grip are used.
        manifests: id -> name of its manifest in the file, for nodes that don't come with grip.
        variables: id of a cell -> its name in the file.
        statements: the body of `create_root`, laid out.
    """

    grip: bool = False
    codes: bool = False
    identifiers: Identifiers = field(default_factory=lambda: Identifiers(_OWN_NAMES))
    parts: set[str] = field(default_factory=lambda: {"labels"})
    kinds: KindSource = field(default_factory=KindSource)
    imports: dict[str, dict[str, str]] = field(default_factory=dict)
    builtin: bool = False
    manifests: dict[str, str] = field(default_factory=dict)
    variables: dict[int, str] = field(default_factory=dict)
    statements: list[str] = field(default_factory=list)

    def visible(self, part: Part, *, around: bool = False) -> dict[str, str]:
        """Return the variables that a node sees: name in the task -> name in the file."""
        scope = part.around if around else part.scope
        found = {}
        for name in scope.visible():
            cell = scope.find(name)
            if cell is not None:
                found[name] = self.variables[id(cell)]
        return found


def asks_for_codes(resolved: Resolved) -> bool:
    """Tell whether some edge is refined by a failure code."""
    tables = [resolved.ends, *(edges for part in resolved.root.walk() for edges in (part.exits, part.edges))]
    rules = [rule for part in resolved.root.walk() for rule in getattr(part.node, "rules", ())]
    said = [label for rule in rules for one in rule.when.values() for label in ([one] if isinstance(one, str) else one)]
    return any(code is not None for table in tables for (_, _, code), _ in table) or any("." in s for s in said)


def is_fresh(part: Part) -> bool:
    """Tell whether the node has variables that begin anew when it is entered."""
    return part.declares and not isinstance(part.node, model.Leaf)
