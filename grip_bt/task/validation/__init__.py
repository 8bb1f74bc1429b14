"""Is a task right: every issue at once, before anything runs. The rules are listed in `docs/validation_rules.md`."""

from __future__ import annotations

from grip_bt.base.issue import Issue, Report, ordered
from grip_bt.task import Task
from grip_bt.task.catalog import Catalog
from grip_bt.task.document import Document

from .codes import SEVERITY, STRUCTURAL
from .dataflow import check_dataflow
from .expressions import check_expressions
from .leaves import check_names, check_numbers, check_subtasks
from .outcomes import check_outcomes, check_reach
from .parts import check_equipment, check_foreign, check_messages
from .possible import Possible
from .subtasks import Checked, Subtasks
from .survey import Survey
from .variables import check_parallel, check_variables

__all__ = ["SEVERITY", "structural_issues", "survey_of", "validate"]


def validate(task: Task, catalog: Catalog, document: Document | None = None) -> Report:
    """Check a task against the nodes that exist.

    Args:
        task: the task.
        catalog: the nodes that exist.
        document: the text that the task was read from; with it, issues have lines and columns.

    Returns:
        All issues, in the order of the text.
    """
    return ordered(_checked(task, catalog, document, None).issues)


def survey_of(task: Task, catalog: Catalog) -> Survey:
    """Return what the rules read, after all rules: with what is known of the files that the task runs."""
    return _checked(task, catalog, None, None)


def structural_issues(task: Task, catalog: Catalog) -> list[Issue]:
    """Return the errors without which every name of a task leads somewhere: it can be compiled, right or not."""

    def inside(task: Task) -> Checked:
        return _structural(task, catalog, known), {}

    known = Subtasks(catalog, inside)
    return _structural(task, catalog, known)


def _structural(task: Task, catalog: Catalog, subtasks: Subtasks) -> list[Issue]:
    survey = Survey(task, catalog, None, subtasks)
    for rule in (check_names, check_foreign, check_subtasks, check_variables, check_expressions, check_parallel):
        rule(survey)
    check_outcomes(survey, None)
    return [issue for issue in survey.issues if issue.code in STRUCTURAL]


def _checked(task: Task, catalog: Catalog, document: Document | None, subtasks: Subtasks | None) -> Survey:
    """Return the survey of a task after all rules."""

    def inside(task: Task) -> Checked:
        survey = _checked(task, catalog, None, known)
        return survey.issues, survey.written

    known = subtasks or Subtasks(catalog, inside)
    survey = Survey(task, catalog, document, known)
    possible = Possible(survey)
    check_names(survey)
    check_numbers(survey)
    check_messages(survey)
    check_equipment(survey)
    check_foreign(survey)
    check_subtasks(survey)
    check_variables(survey)
    check_expressions(survey)
    check_outcomes(survey, possible)
    check_reach(survey, possible)
    check_parallel(survey)
    check_dataflow(survey, possible)
    return survey
