"""The simulated world: SAPIEN in a process of its own, and adapters to GRIP's ports. Importing this loads no sapien."""

from grip_sim.cameras import render_support
from grip_sim.referee import ObjectTruth
from grip_sim.simulation import Simulation, start_simulation
from grip_sim.specs import WorldSpec
from grip_sim.worlds import load_world

__all__ = ["ObjectTruth", "Simulation", "WorldSpec", "load_world", "render_support", "start_simulation"]
