"""What is wrong, or worth knowing, about a robot's files."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any, Literal

from grip_bt.base.errors import DocumentError, GripError

Severity = Literal["error", "warning"]


@dataclass(frozen=True, slots=True)
class Finding:
    """One of them.

    Attributes:
        severity: an `error` keeps the robot from being used.
        code: what kind it is, such as `missing-mesh`.
        message: what is wrong and what to do.
        source: the file; empty where there is none.
        line: 1-based line, or None.
    """

    severity: Severity
    code: str
    message: str
    source: str = ""
    line: int | None = None

    def __str__(self) -> str:
        place = self.source + (f":{self.line}" if self.line is not None else "")
        return f"{place + ': ' if place else ''}{self.severity} [{self.code}] {self.message}"

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON data."""
        return asdict(self)


def finding_of(error: GripError) -> Finding:
    """Return an error of reading as a finding."""
    if isinstance(error, DocumentError):
        return Finding("error", "bad-file", error.message, error.source, error.line)
    return Finding("error", "bad-robot", str(error))


def errors(findings: Iterable[Finding]) -> list[Finding]:
    """Return those that keep the robot from being used."""
    return [finding for finding in findings if finding.severity == "error"]
