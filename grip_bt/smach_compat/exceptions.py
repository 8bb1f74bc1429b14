"""The errors of smach. Making one logs it: legacy code relies on seeing them even where a callback swallows them."""

from __future__ import annotations

from grip_bt.base.errors import GripError
from grip_bt.smach_compat._settings import hooks


class SmachError(GripError):
    """Root of smach's errors; takes exactly one message."""

    def __init__(self, message: str):
        super().__init__(message)
        hooks.logerr(f"{type(self).__name__}: {message}")


class InvalidStateError(SmachError):
    """A state is missing, given twice, or can't be used here."""


class InvalidTransitionError(SmachError):
    """An outcome isn't registered or leads nowhere."""


class InvalidConstructionError(SmachError):
    """A container that isn't open was asked for something that needs it open."""


class InvalidUserCodeError(SmachError):
    """Code of the user raised, or touched userdata that it hadn't declared."""
