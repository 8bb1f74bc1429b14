"""The simulated world: SAPIEN in a process of its own, and adapters to GRIP's ports. Importing this loads no sapien."""

from .referee import ObjectTruth
from .rendering import render_support
from .simulation import Simulation, start_simulation
from .specs import WorldSpec
from .tables import table_world

__all__ = ["ObjectTruth", "Simulation", "WorldSpec", "render_support", "start_simulation", "table_world"]
