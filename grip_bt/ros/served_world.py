"""A simulated world's own services: those of the standard `simulation_interfaces` 2.1, and ours for what it lacks.

Source: https://github.com/ros-simulation/simulation_interfaces, which Gazebo, Isaac Sim and O3DE serve too. Ours are
`/grip_sim/save`, `/grip_sim/restore` (std_srvs/Trigger), `/grip_sim/reset_to_seed`, `/grip_sim/inject_fault`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from geometry_msgs.msg import Twist, Vector3
from std_srvs.srv import Trigger

from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.values import Pose
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.types import Message, load_type
from grip_bt.ros.convert_values import header, pose_from_message, pose_to_message
from grip_bt.ros.interfaces.build import ensure_package

PACKAGE = "simulation_interfaces"
FEATURES = (
    ("SPAWNING", "DELETING", "ENTITY_STATE_GETTING", "ENTITY_STATE_SETTING")
    + ("SIMULATION_RESET", "SIMULATION_STATE_GETTING", "SIMULATION_STATE_SETTING")
    + ("SIMULATION_STATE_PAUSE", "STEP_SIMULATION_SINGLE", "STEP_SIMULATION_MULTIPLE")
)
Handler = Callable[[Message, Message], object]


class SimulatedWorld(Protocol):
    """What is served; each raises GripError where it can't be done, UnknownNameError where an object isn't there."""

    def objects(self) -> Mapping[str, tuple[Pose, Array]]:
        """Return each object's pose in world, and how it moves: 3 velocities [m/s] and 3 turning rates [rad/s]."""

    def spawn(self, name: str, resource: str, pose: Pose) -> None:
        """Add an object of the library or the project, or of a file."""

    def remove(self, name: str) -> None:
        """Take an object away."""

    def place(self, name: str, pose: Pose) -> None:
        """Put an object elsewhere, at rest."""

    def reset(self, seed: int | None = None) -> None:
        """Bring everything to where it was in the beginning, or to where another seed has it."""

    def save(self) -> None:
        """Keep where everything is."""

    def restore(self) -> None:
        """Bring everything to where it was saved."""

    def pause(self) -> None:
        """Let no time pass."""

    def resume(self) -> None:
        """Let time go on."""

    def step(self, steps: int) -> None:
        """Let steps of time pass in a pause."""

    def inject(self, name: str, fault: str) -> None:
        """Have something go wrong from now on, as a world's file says it."""


class _RefusedError(Exception):
    def __init__(self, code: int, message: str = ""):
        super().__init__(message)
        self.code = code


class SimulationServices:
    """Serves a world; made from any thread, and it ends with the bus.

    Args:
        now: the time of stamps [s].
    """

    def __init__(self, bus: Bus, world: SimulatedWorld, now: Callable[[], float]):
        ensure_package(PACKAGE)
        ensure_package("grip_msgs")
        self._world, self._now = world, now
        self._result, self._state = load_type(f"{PACKAGE}/msg/Result"), load_type(f"{PACKAGE}/msg/SimulationState")
        self._current = self._state.STATE_PLAYING
        handlers: dict[str, Handler] = {
            "GetSimulatorFeatures": self._features,
            "GetEntities": self._entities,
            "GetEntityState": self._entity_state,
            "SetEntityState": self._set_entity_state,
            "SpawnEntity": self._spawn,
            "DeleteEntity": lambda asked, said: world.remove(self._known(asked.entity)),
            "ResetSimulation": self._reset,
            "GetSimulationState": self._simulation_state,
            "SetSimulationState": self._set_simulation_state,
            "StepSimulation": self._step,
        }
        own: dict[str, tuple[Any, Callable[[Message], None]]] = {
            "save": (Trigger, lambda asked: world.save()),
            "restore": (Trigger, lambda asked: world.restore()),
            "reset_to_seed": (load_type("grip_msgs/srv/ResetToSeed"), lambda asked: world.reset(asked.seed)),
            "inject_fault": (
                load_type("grip_msgs/srv/InjectFault"),
                lambda asked: world.inject(asked.name, asked.fault),
            ),
        }
        node: Any = bus.node

        def begin() -> None:
            for name, handler in handlers.items():
                service = "/" + re.sub("(?<!^)(?=[A-Z])", "_", name).lower()
                node.create_service(load_type(f"{PACKAGE}/srv/{name}"), service, self._answering(handler))
            for name, (kind, act) in own.items():
                node.create_service(kind, f"/grip_sim/{name}", _acting(act))

        bus.ask(begin)
        self.names = ("/spawn_entity", "/reset_simulation", "/set_simulation_state", "/grip_sim/inject_fault")

    def _answering(self, handler: Handler) -> Handler:
        def answer(asked: Message, said: Message) -> Message:
            code, message = self._result.RESULT_OK, ""
            try:
                handler(asked, said)
            except _RefusedError as error:
                code, message = error.code, str(error)
            except UnknownNameError as error:
                code, message = self._result.RESULT_NOT_FOUND, str(error)
            except (GripError, ValueError) as error:
                code, message = self._result.RESULT_OPERATION_FAILED, str(error)
            if hasattr(said, "result"):
                said.result.result, said.result.error_message = code, message
            return said

        return answer

    def _features(self, asked: Message, said: Message) -> None:
        said.features.features = [getattr(said.features, name) for name in FEATURES]
        said.features.custom_info = (
            "entities are the world's objects; a uri is an object's name or its file; time goes on after a reset"
        )

    def _entities(self, asked: Message, said: Message) -> None:
        if asked.filters.categories or asked.filters.tags.tags or asked.filters.bounds.type:
            raise _RefusedError(self._result.RESULT_FEATURE_UNSUPPORTED, "only `filter`, of names, is supported")
        try:
            wanted = re.compile(asked.filters.filter)
        except re.error as error:
            raise ValueError(f"the filter is no regular expression: {error}") from None
        said.entities = [name for name in self._world.objects() if wanted.search(name)]

    def _known(self, name: str) -> str:
        objects = self._world.objects()
        if name not in objects:
            raise UnknownNameError("object", name, objects)
        return name

    def _entity_state(self, asked: Message, said: Message) -> None:
        pose, speeds = self._world.objects()[self._known(asked.entity)]
        linear, angular = (dict(zip("xyz", map(float, part), strict=True)) for part in (speeds[:3], speeds[3:]))
        said.state.header, said.state.pose = header("world", self._now()), pose_to_message(pose)
        said.state.twist = Twist(linear=Vector3(**linear), angular=Vector3(**angular))

    def _set_entity_state(self, asked: Message, said: Message) -> None:
        moves = asked.state.twist != type(asked.state.twist)()
        if asked.set_acceleration or (asked.set_twist and moves):
            raise _RefusedError(self._result.RESULT_FEATURE_UNSUPPORTED, "an object is put at rest: set its pose only")
        if asked.set_pose:
            self._world.place(
                self._known(asked.entity), self._pose(asked.state.pose, asked.state.header.frame_id, said)
            )

    def _spawn(self, asked: Message, said: Message) -> None:
        resource = asked.entity_resource
        if resource.resource_string:
            raise _RefusedError(said.UNSUPPORTED_FORMAT, "give the resource's `uri`: an object's name or its file")
        if not resource.uri:
            raise _RefusedError(said.NO_RESOURCE, "the resource has no `uri`: an object's name or its file")
        there, name = self._world.objects(), asked.name or resource.uri
        if name in there and not asked.allow_renaming:
            raise _RefusedError(said.NAME_NOT_UNIQUE, f"there is an object {name!r} already")
        if name in there:
            name = next(f"{name}_{n}" for n in range(2, len(there) + 3) if f"{name}_{n}" not in there)
        pose = self._pose(asked.initial_pose.pose, asked.initial_pose.header.frame_id, said)
        self._world.spawn(name, resource.uri.removeprefix("file://"), pose)
        said.entity_name = name

    def _pose(self, message: Message, frame: str, said: Message) -> Pose:
        if frame not in ("", "world"):
            raise _RefusedError(said.INVALID_POSE, f"poses are in the frame world, not in {frame!r}")
        return pose_from_message(message)

    def _reset(self, asked: Message, said: Message) -> None:
        if asked.scope not in (asked.SCOPE_DEFAULT, asked.SCOPE_ALL, asked.SCOPE_STATE | asked.SCOPE_SPAWNED):
            raise _RefusedError(self._result.RESULT_FEATURE_UNSUPPORTED, "state and spawned objects are reset together")
        self._world.reset()

    def _simulation_state(self, asked: Message, said: Message) -> None:
        said.state.state = self._current

    def _set_simulation_state(self, asked: Message, said: Message) -> None:
        state, wanted = self._state, asked.state.state
        if wanted not in (state.STATE_PLAYING, state.STATE_PAUSED, state.STATE_STOPPED):
            raise _RefusedError(said.INCORRECT_TRANSITION, "it can be playing, paused, or stopped")
        if wanted == self._current:
            raise _RefusedError(said.ALREADY_IN_TARGET_STATE)
        self._current = wanted
        if wanted == state.STATE_PLAYING:
            return self._world.resume()
        self._world.pause()
        if wanted == state.STATE_STOPPED:
            self._world.reset()

    def _step(self, asked: Message, said: Message) -> None:
        if self._current == self._state.STATE_PLAYING:
            raise _RefusedError(self._result.RESULT_INCORRECT_STATE, "pause it first: steps are for a paused world")
        self._current = self._state.STATE_PAUSED
        self._world.step(asked.steps)


def _acting(act: Callable[[Message], None]) -> Handler:
    def answer(asked: Message, said: Message) -> Message:
        try:
            act(asked)
            said.success = True
        except (GripError, ValueError) as error:
            said.message = str(error)
        return said

    return answer
