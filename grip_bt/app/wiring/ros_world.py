"""A simulated world's own services: those of the standard `simulation_interfaces` 2.1, and ours for what it lacks.

Source: https://github.com/ros-simulation/simulation_interfaces, which Gazebo, Isaac Sim and O3DE serve too. Ours are
`/grip_sim/save`, `/grip_sim/restore` (std_srvs/Trigger), `/grip_sim/reset_to_seed`, `/grip_sim/inject_fault`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.values import Pose
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.types import Message, load_type
from grip_bt.ros.convert_values import header, pose_from_message, pose_to_message
from grip_bt.ros.interfaces.build import ensure_package
from grip_sim.faults import read_faults
from grip_sim.simulation import Simulation
from grip_sim.specs import ObjectSpec, WorldSpec
from grip_sim.worlds import object_at

PACKAGE = "simulation_interfaces"
FEATURES = (
    ("SPAWNING", "DELETING", "ENTITY_STATE_GETTING", "ENTITY_STATE_SETTING")
    + ("SIMULATION_RESET", "SIMULATION_STATE_GETTING", "SIMULATION_STATE_SETTING")
    + ("SIMULATION_STATE_PAUSE", "STEP_SIMULATION_SINGLE", "STEP_SIMULATION_MULTIPLE")
)
Handler = Callable[[Message, Message], object]
_Kept = tuple[tuple[ObjectSpec, ...], Mapping[str, Array]]


class _RefusedError(Exception):
    def __init__(self, code: int, message: str = ""):
        super().__init__(message)
        self.code = code


class SimulationServices:
    """Serves a world; made from any thread, and it ends with the bus.

    Args:
        drawn: returns the world as a seed draws it.
        project: the folder whose objects can be spawned.
        now: the time of stamps [s].
    """

    def __init__(
        self,
        bus: Bus,
        simulation: Simulation,
        drawn: Callable[[int], WorldSpec],
        project: Path,
        now: Callable[[], float],
    ):
        ensure_package(PACKAGE)
        ensure_package("grip_msgs")
        self._simulation, self._drawn, self._project, self._now = simulation, drawn, project, now
        self._first = self._saved = self._kept()
        self._result, self._state = load_type(f"{PACKAGE}/msg/Result"), load_type(f"{PACKAGE}/msg/SimulationState")
        self._current = self._state.STATE_PLAYING
        standard: dict[str, Handler] = {
            "GetSimulatorFeatures": self._features,
            "GetEntities": self._entities,
            "GetEntityState": self._entity_state,
            "SetEntityState": self._set_entity_state,
            "SpawnEntity": self._spawn,
            "DeleteEntity": lambda asked, said: simulation.remove(self._known(asked.entity)),
            "ResetSimulation": self._reset,
            "GetSimulationState": self._simulation_state,
            "SetSimulationState": self._set_simulation_state,
            "StepSimulation": self._step,
        }
        own: dict[str, tuple[str, Handler]] = {
            "save": ("std_srvs/srv/Trigger", self._save),
            "restore": ("std_srvs/srv/Trigger", lambda asked, said: self._put_back(self._saved)),
            "reset_to_seed": ("grip_msgs/srv/ResetToSeed", self._reset_to_seed),
            "inject_fault": ("grip_msgs/srv/InjectFault", self._inject),
        }
        served = {f"/grip_sim/{name}": each for name, each in own.items()}
        for name, handler in standard.items():
            service = "/" + re.sub("(?<!^)(?=[A-Z])", "_", name).lower()
            served[service] = (f"{PACKAGE}/srv/{name}", handler)
        node: Any = bus.node

        def begin() -> None:
            for service, (kind, handler) in served.items():
                node.create_service(load_type(kind), service, self._answering(handler))

        bus.ask(begin)

    def _answering(self, handler: Handler) -> Handler:
        def answer(asked: Message, said: Message) -> Message:
            code, message = self._result.RESULT_OK, ""
            try:
                handler(asked, said)
            except _RefusedError as error:
                code, message = error.code, str(error)
            except UnknownNameError as error:
                code, message = self._result.RESULT_NOT_FOUND, str(error)
            except (GripError, ValueError, re.error) as error:
                code, message = self._result.RESULT_OPERATION_FAILED, str(error)
            if hasattr(said, "result"):
                said.result.result, said.result.error_message = code, message
            elif hasattr(said, "success"):
                said.success, said.message = code == self._result.RESULT_OK, message
            return said

        return answer

    def _features(self, asked: Message, said: Message) -> None:
        said.features.features = [getattr(said.features, name) for name in FEATURES]

    def _entities(self, asked: Message, said: Message) -> None:
        if asked.filters.categories or asked.filters.tags.tags or asked.filters.bounds.type:
            raise _RefusedError(self._result.RESULT_FEATURE_UNSUPPORTED, "only `filter`, of names, is supported")
        said.entities = [name for name in self._objects() if re.search(asked.filters.filter, name)]

    def _objects(self) -> Mapping[str, tuple[Pose, Array]]:
        """Return each object's pose in world, and how it moves: 3 velocities [m/s] and 3 turning rates [rad/s]."""
        specs, kept = self._kept()
        rows = zip(specs, kept["poses"].tolist(), kept["object_speeds"], strict=True)
        return {spec.name: (Pose(row[:3], row[3:]), speeds) for spec, row, speeds in rows}

    def _kept(self) -> _Kept:
        return self._simulation.spec.objects, self._simulation.kept()

    def _put_back(self, kept: _Kept) -> None:
        objects, states = kept
        if self._simulation.spec.objects != objects:
            for there in self._simulation.spec.objects:
                self._simulation.remove(there.name)
            for wanted in objects:
                self._simulation.spawn(wanted)
        self._simulation.put_back(states, cancel=True)

    def _save(self, asked: Message, said: Message) -> None:
        self._saved = self._kept()

    def _reset_to_seed(self, asked: Message, said: Message) -> None:
        objects = self._drawn(asked.seed).objects
        poses = np.array([[*each.pose.position, *each.pose.quaternion] for each in objects]).reshape(-1, 7)
        self._first = objects, {**self._first[1], "poses": poses, "object_speeds": np.zeros((len(objects), 6))}
        self._put_back(self._first)

    def _inject(self, asked: Message, said: Message) -> None:
        for name, fault in read_faults([f"{asked.name}: {asked.fault}"]).items():
            self._simulation.inject(name, fault)

    def _known(self, name: str) -> str:
        objects = self._objects()
        if name not in objects:
            raise UnknownNameError("object", name, objects)
        return name

    def _entity_state(self, asked: Message, said: Message) -> None:
        pose, speeds = self._objects()[self._known(asked.entity)]
        said.state.header, said.state.pose = header("world", self._now()), pose_to_message(pose)
        twist = said.state.twist
        twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.x, twist.angular.y, twist.angular.z = (
            speeds.tolist()
        )

    def _set_entity_state(self, asked: Message, said: Message) -> None:
        moves = asked.state.twist != type(asked.state.twist)()
        if asked.set_acceleration or (asked.set_twist and moves):
            raise _RefusedError(self._result.RESULT_FEATURE_UNSUPPORTED, "an object is put at rest: set its pose only")
        if asked.set_pose:
            self._simulation.referee.move_object(
                self._known(asked.entity), self._pose(asked.state.pose, asked.state.header.frame_id, said)
            )

    def _spawn(self, asked: Message, said: Message) -> None:
        resource = asked.entity_resource
        if resource.resource_string:
            raise _RefusedError(said.UNSUPPORTED_FORMAT, "give the resource's `uri`: an object's name or its file")
        if not resource.uri:
            raise _RefusedError(said.NO_RESOURCE, "the resource has no `uri`: an object's name or its file")
        there, name = self._objects(), asked.name or resource.uri
        if name in there and not asked.allow_renaming:
            raise _RefusedError(said.NAME_NOT_UNIQUE, f"there is an object {name!r} already")
        if name in there:
            name = next(f"{name}_{n}" for n in range(2, len(there) + 3) if f"{name}_{n}" not in there)
        pose = self._pose(asked.initial_pose.pose, asked.initial_pose.header.frame_id, said)
        self._simulation.spawn(object_at(name, resource.uri.removeprefix("file://"), pose, self._project))
        said.entity_name = name

    def _pose(self, message: Message, frame: str, said: Message) -> Pose:
        if frame not in ("", "world"):
            raise _RefusedError(said.INVALID_POSE, f"poses are in the frame world, not in {frame!r}")
        return pose_from_message(message)

    def _reset(self, asked: Message, said: Message) -> None:
        if asked.scope not in (asked.SCOPE_DEFAULT, asked.SCOPE_ALL, asked.SCOPE_STATE | asked.SCOPE_SPAWNED):
            raise _RefusedError(self._result.RESULT_FEATURE_UNSUPPORTED, "state and spawned objects are reset together")
        self._put_back(self._first)

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
            return self._simulation.resume()
        self._simulation.pause()
        if wanted == state.STATE_STOPPED:
            self._put_back(self._first)

    def _step(self, asked: Message, said: Message) -> None:
        if self._current == self._state.STATE_PLAYING:
            raise _RefusedError(self._result.RESULT_INCORRECT_STATE, "pause it first: steps are for a paused world")
        self._current = self._state.STATE_PAUSED
        self._simulation.step(asked.steps)
