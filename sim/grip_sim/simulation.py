"""A simulation to work with: the process, the adapters to its parts, and its certain end."""

from __future__ import annotations

from collections.abc import Mapping

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.commanders.description.load import load_robot
from grip_sim.adapters import SimCamera, SimExecutor, SimHand, SimReferee, check_positive
from grip_sim.client import SimClient
from grip_sim.specs import WorldSpec

SETTLE = 0.5
"""How long objects are left to come to rest at the start [s]."""


class Simulation(SimClient):
    """A running simulator. Physics advances only while something is under way. Implements `grip_bt.base.ports.Stepped`.

    Attributes:
        spec: the world.
        referee: the truth; for judges, never for a task.
    """

    def __init__(self, spec: WorldSpec, pace: float | None = None, hold: int | None = None):
        if pace is not None:
            check_positive("pace", pace)
        self._robot = load_robot(spec.robot)  # first: an unknown robot is found before a process runs
        super().__init__(spec, pace, hold)
        self.spec, self.referee = spec, SimReferee(self)

    def executor(self, group: str) -> SimExecutor:
        """Return what moves a group of joints.

        Raises:
            UnknownNameError: the robot has no such group.
        """
        return SimExecutor(self, self._robot.group(group))

    def hand(self, group: str) -> SimHand:
        """Return what moves the fingers of a group, likewise."""
        return SimHand(self, self._robot.group(group))

    def camera(self, name: str) -> SimCamera:
        """Return a camera.

        Raises:
            UnknownNameError: the world has no such camera.
        """
        cameras = {camera.name: camera for camera in self.spec.cameras}
        if name not in cameras:
            raise UnknownNameError("camera", name, cameras)
        return SimCamera(self, name, cameras[name].info())

    def settle(self, seconds: float = SETTLE) -> None:
        """Let simulated time pass and wait for it.

        Raises:
            SimulatorLostError: the simulator ended meanwhile.
        """
        wait = self.move("wait", seconds=seconds)
        wait.wait()
        wait.result()

    def kept(self) -> dict[str, Array]:
        """Return everything that moves in the world, and how, for `put_back` in another process."""
        return dict(self.ask("kept").arrays)

    def put_back(self, kept: Mapping[str, Array]) -> None:
        """Bring everything that moves to where it was kept, in a world of the same spec.

        Raises:
            GripError: it was another world, or something moves.
        """
        self.ask("put_back", dict(kept))

    def pause(self) -> None:
        """Have the world stand still in the middle of whatever moves, and the clock with it; see `Pausable`."""
        self.ask("pause")
        self.clock.pause()

    def resume(self) -> None:
        """Have the world go on."""
        self.clock.resume()
        self.ask("resume")

    def keep_to_simulated(self, only: bool) -> None:
        """Have the clock show simulated time alone, or let ours go on in it while nothing moves."""
        self.clock.keep_to_simulated(only)


def start_simulation(spec: WorldSpec, pace: float | None = None, hold: int | None = None) -> Simulation:
    """Start a simulator in a process of its own and let its objects come to rest.

    Args:
        pace: simulated seconds per second; None for as fast as it goes.
        hold: file descriptor over which somebody else may have the robot hold; None for nobody.

    Raises:
        SimulatorLostError: it can't be started; the message holds what it printed.
        UnknownNameError: there is no such robot.
        ValueError: the pace isn't positive.
    """
    simulation = Simulation(spec, pace, hold)
    try:
        simulation.settle()
    except BaseException:
        simulation.close()
        raise
    return simulation
