"""What a MoveIt configuration package prefers for each group, in the words of this package's planners and solvers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ..names import SOLVERS
from ..robots.description import Preference
from .package import MoveItPackage
from .settings import PlannerChoice

USUAL = "RRTConnect"
"""The planner of a group without `default_planner_config`: MoveIt leaves it to OMPL then, whose choice this is, other
than for a group with a `projection_evaluator` (LBKPIECE1)."""
_PLUGINS = (("trac_ik", "trac_ik"), ("kdl", "damped_least_squares"), ("lma", "damped_least_squares"))
"""Part of a plugin's name -> the solver here that works like it."""


def preferences_of(
    package: MoveItPackage, groups: Iterable[str], planners: Iterable[str]
) -> dict[str, dict[str, Preference]]:
    """Return group -> field of an arm (`planner`, `kinematics`, `speed`, `acceleration`) -> what is preferred.

    What there is no equal of here isn't among them; `unknown` of the field's preference then says what was asked for.

    Args:
        package: what its YAML files say.
        planners: names of those that there are here.
    """
    known, found = frozenset(planners), {}
    for group in groups:
        fields: dict[str, Preference] = {}
        if group in package.planners:
            choice = package.planners[group]
            default = choice.planners.get(choice.default, choice.default)
            fields["planner"] = replace(
                _first([default or USUAL], known, "ompl_planning.yaml"), parameters=_parameters(choice, known)
            )
        if group in package.kinematics:
            plugin = package.kinematics[group]
            solvers = [solver for part, solver in _PLUGINS if part in plugin.lower() and solver in SOLVERS]
            fields["kinematics"] = _first([*solvers, plugin], frozenset(SOLVERS), "kinematics.yaml")
        for field, factor in (("speed", "velocity"), ("acceleration", "acceleration")):
            if factor in package.scaling:
                fields[field] = Preference(package.scaling[factor], "joint_limits.yaml")
        found[group] = fields
    return {group: fields for group, fields in found.items() if fields}


def _parameters(choice: PlannerChoice, known: frozenset[str]) -> dict[str, dict[str, float]]:
    """Return planner -> its parameters; of several configurations of one planner, the default or else the first."""
    order = sorted(choice.planners, key=lambda name: name != choice.default)
    found: dict[str, dict[str, float]] = {}
    for name in order:
        if choice.planners[name] in known:
            found.setdefault(choice.planners[name], dict(choice.parameters.get(name, {})))
    return {planner: parameters for planner, parameters in found.items() if parameters}


def _first(wanted: list[str], known: frozenset[str], source: str) -> Preference:
    value = next((name for name in wanted if name in known), None)
    return Preference(value, source, unknown="" if value else ", ".join(wanted))
