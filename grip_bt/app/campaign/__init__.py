"""Campaigns: tasks, or one task in several ways, on many seeds; how often they succeed, and why not."""

from .file import Campaign, Results, begin, head_of, read, read_campaign
from .report import as_csv, as_text, summary
from .trials import Trials, check

__all__ = [
    "Campaign",
    "Results",
    "Trials",
    "as_csv",
    "as_text",
    "begin",
    "check",
    "head_of",
    "read",
    "read_campaign",
    "summary",
]
