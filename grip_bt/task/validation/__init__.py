"""Is a task right: every issue at once, before anything runs. The rules are listed in `docs/validation_rules.md`."""

from __future__ import annotations

from grip_bt.base.issue import Issue, Report, ordered
from grip_bt.task import Task
from grip_bt.task.catalog import Catalog
from grip_bt.task.document import Document

from .analysis import TaskAnalysis
from .codes import SEVERITY, STRUCTURAL
from .dataflow import check_dataflow
from .expressions import check_expressions
from .leaves import check_names, check_subtasks
from .numbers import check_numbers
from .outcomes import check_outcomes, check_reach
from .parallels import check_parallel
from .parts import check_foreign, check_messages, check_parts
from .possible import PossibleOutcomes
from .subtasks import Checked, Subtasks
from .variables import check_variables

__all__ = ["SEVERITY", "structural_issues", "analyse", "validate"]


def validate(task: Task, catalog: Catalog, document: Document | None = None) -> Report:
    """Check a task against the nodes that exist; return all issues, in the order of the text.

    Args:
        document: the text that the task was read from; with it, issues have lines and columns.
    """
    return ordered(_checked(task, catalog, document, None).issues)


def analyse(task: Task, catalog: Catalog) -> TaskAnalysis:
    """Return what the rules read, after all rules: with what is known of the files that the task runs."""
    return _checked(task, catalog, None, None)


def structural_issues(task: Task, catalog: Catalog) -> list[Issue]:
    """Return the errors without which every name of a task leads somewhere: it can be compiled, right or not."""
    return _checked(task, catalog, None, None, structure_only=True).issues


_STRUCTURAL_RULES = (check_names, check_foreign, check_subtasks, check_variables, check_expressions, check_parallel)
_FURTHER_RULES = (check_numbers, check_messages, check_parts)


def _checked(
    task: Task, catalog: Catalog, document: Document | None, subtasks: Subtasks | None, structure_only: bool = False
) -> TaskAnalysis:

    def inside(task: Task) -> Checked:
        analysis = _checked(task, catalog, None, known, structure_only)
        return analysis.issues, analysis.written

    known = subtasks or Subtasks(catalog, inside)
    analysis = TaskAnalysis(task, catalog, document, known)
    for rule in _STRUCTURAL_RULES:
        rule(analysis)
    if structure_only:
        check_outcomes(analysis, None)
        analysis.issues = [issue for issue in analysis.issues if issue.code in STRUCTURAL]
        return analysis
    for rule in _FURTHER_RULES:
        rule(analysis)
    possible = PossibleOutcomes(analysis)
    check_outcomes(analysis, possible)
    check_reach(analysis, possible)
    check_dataflow(analysis, possible)
    return analysis
