"""Campaigns: tasks, or one task in several ways, on many seeds; how often they succeed, and why not."""

from grip_bt.app.campaign.trials import check

from .file import Campaign, head_of, read_campaign
from .report import as_csv, as_text, summary
from .results import Results, begin, read
from .trials import Trials

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
