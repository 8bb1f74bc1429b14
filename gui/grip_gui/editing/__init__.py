"""Task files while they are edited: the server owns them, and every page, form and text pane changes them here."""

from .desk import EditDesk
from .errors import ChangedOnDiskError, StaleEditError, UnfinishedTextError
from .sheet import Sheet

__all__ = ["ChangedOnDiskError", "EditDesk", "Sheet", "StaleEditError", "UnfinishedTextError"]
