"""Timing of paths."""

from typing import Literal

Timing = Literal["direct", "toppra"]
"""Who finds the fastest velocities along a path: TOPP-RA solved directly, or the library `toppra`; they agree."""
