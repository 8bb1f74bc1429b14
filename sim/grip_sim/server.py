"""`python -m grip_sim.server FD [HOLD]`: the simulator's process, started by `grip_sim.client` with open sockets.

Physics advances only while something is under way; the process ends when its client is gone.
"""

from __future__ import annotations

import gc
import os
import select
import signal
import socket
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from grip_bt.base.arrays import Array, Indices
from grip_bt.base.errors import GripError
from grip_bt.base.values import Pose, Trajectory
from grip_bt.commanders.trajectory.stopping import even_ramp
from grip_sim.cameras.rig import Film
from grip_sim.connection import ClosedError, pack, receive
from grip_sim.faults import Fault
from grip_sim.motions import STILL, Brake, ComeToRest, Ended, Follow, Motion, MoveHand, Wait
from grip_sim.referee import judge
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec
from grip_sim.world import World

STEPS_PER_LOOK = 4
"""Steps between two looks at the connection: 17 ms of simulated time, a few ms of ours."""
SIGN_OF_LIFE = 10.0
"""While it is paused, the client is told this often that we are there [s]."""
TELL_TIME, TELL_TIME_IN_TURNS = 0.02, 0.1
"""While something moves, the client is told the time this often [s of ours]; one that takes turns waits for no time but
that until which the world goes."""
SILENT = frozenset({"follow", "move_hand", "wait", "go", "stand", "go_freely"})
"""Calls that aren't answered at once: motions are when they end, and what is said of turns never is."""
Answer = Mapping[str, object]
"""What is said, as `grip_bt.base.value_codec` writes it."""
_LOOSE = -(1 << 40)
"""The number of the motion that brakes joints which nothing drives; no call has it."""


class Server:
    """Obeys one client; somebody else may have the robot hold for good by any word over `hold`."""

    def __init__(
        self, connection: socket.socket, spec: WorldSpec, pace: float | None, hold: socket.socket | None = None
    ):
        self._connection, self._pace, self._hold = connection, pace, hold
        self._film: Film | None = None
        self._motions: dict[int, Motion] = {}
        self._begin(spec)

    def _begin(self, spec: WorldSpec) -> None:
        """Let a world begin in place of the one that was there, of which nothing stays."""
        self._call_end_film()
        for number, motion in self._motions.items():
            self._tell_end(number, motion, Ended("canceled", "another world begins"))
        self._motions = {}
        self._frozen = self._held = self._asked = False
        self._in_turns = self._going = False
        self._until: float | None = None
        self._told = self._due = 0.0
        self.world = World(spec)
        self.world.faults.on_event = lambda *event: self._send({"id": 0, "fault": event})

    def serve(self) -> None:
        """Obey until the client is gone."""
        try:
            while True:
                channels = [self._connection] if self._hold is None else [self._hold, self._connection]
                ready = select.select(channels, [], [], self._patience())[0]
                if self._hold in ready:
                    self._hold_for_good()
                elif ready:
                    self._obey(receive(self._connection))
                elif self._stands:
                    self._send({"id": 0})
                elif self._motions or self._going:
                    self._advance()
        except (ClosedError, BrokenPipeError, ConnectionResetError):
            return
        finally:
            self._call_end_film()

    @property
    def _stands(self) -> bool:
        """Whether time stands still, whatever is under way."""
        return self._frozen or (self._in_turns and not self._going)

    def _patience(self) -> float | None:
        if self._stands:
            return SIGN_OF_LIFE
        return max(0.0, self._due - time.monotonic()) if self._motions or self._going else None

    def _hold_for_good(self) -> None:
        """Have everything come to rest, move nothing any more, and say so; a channel that was closed says nothing."""
        assert self._hold is not None, "it has said something"
        if not self._hold.recv(64):
            self._hold = None
            return
        self._call_stand()
        self._in_turns = False
        for number in list(self._motions):
            self._brake(number)
        self._brake_loose()
        self._held = self._asked = True
        self._say_held()

    def _brake_loose(self) -> None:
        """Have joints come to rest that move although nothing is under way, as after a motion that was given up."""
        robot, driven = self.world.robot, {row for motion in self._motions.values() for row in motion.rows.tolist()}
        fast = np.flatnonzero(np.abs(robot.velocities()) >= STILL)
        rows = np.array([row for row in fast.tolist() if row not in driven], dtype=np.intp)
        if rows.size:
            measured = robot.measure(rows)
            ramp = even_ramp(measured.names, measured.position, measured.velocity, robot.accelerations(rows))
            self._motions[_LOOSE] = Brake(robot, rows, ramp, self.world.time)

    def _say_held(self) -> None:
        """Say whether joints were measured to rest, to whoever asked for that, when nothing is under way any more."""
        if self._asked and self._hold is not None and (self._frozen or not self._motions):
            self._asked = False
            self._hold.sendall((self._unrest() or "held").encode())

    def _unrest(self) -> str:
        """Return which joint moves fastest, in words; nothing where all rest."""
        speeds = np.abs(self.world.robot.velocities())
        row = int(speeds.argmax())
        if speeds[row] < STILL:
            return ""
        (name,) = self.world.robot.measure(np.array([row])).names
        return f"{name} moves at {speeds[row]:.2f} rad/s{', in a world that is paused' if self._frozen else ''}"

    def _obey(self, fields: dict[str, Any]) -> None:
        number, call = fields.pop("id"), fields.pop("call")
        answer: Answer | None
        try:
            if (handler := getattr(self, f"_call_{call}", None)) is not None:
                answer = handler(number, **fields)
            elif call in OF_WORLD:
                answer = OF_WORLD[call](self.world, **fields)
            else:
                raise LookupError("there is no such call")
        except GripError as error:
            answer = {"error": "refused", "message": str(error)}
        except (LookupError, TypeError, ValueError) as error:  # a wrong call, which changed nothing
            answer = {"error": "refused", "message": f"{call}: {type(error).__name__}: {error}"}
        if answer is not None or call not in SILENT:
            self._send({"id": number, **(answer or {})})

    def _advance(self) -> None:
        began = time.monotonic()
        for _ in range(STEPS_PER_LOOK):
            if self._in_turns and self._until is not None and self.world.time >= self._until:
                return self._call_stand()
            if self._end_what_is_over() and self._in_turns:
                return self._call_stand()
            if not self._motions and not self._in_turns:
                return
            self._step()
        if self._pace is not None:  # messages are obeyed meanwhile, so that a stop isn't late
            self._due = began + STEPS_PER_LOOK * self.world.spec.dt / self._pace
        if time.monotonic() - self._told > (TELL_TIME_IN_TURNS if self._in_turns else TELL_TIME):
            self._told = time.monotonic()
            self._send({"id": 0})

    def _end_what_is_over(self) -> bool:
        ends = [(number, end) for number, motion in self._motions.items() if (end := self._advanced(motion))]
        for number, end in ends:
            self._finish(number, end)
        return bool(ends)

    def _step(self) -> None:
        self.world.step()
        if self._film is not None:
            self._film.stepped(self.world.time)

    def _advanced(self, motion: Motion) -> Ended | None:
        faults = self.world.faults
        if faults.any and motion.rows.size and not isinstance(motion, Brake):
            if why := faults.aborted(self.world.robot.groups_of(motion.rows)):
                return Ended("aborted", why)
        return motion.advance(self.world)

    def _finish(self, number: int, end: Ended) -> None:
        motion = self._motions.pop(number)
        if end.error == "aborted":  # not pressing on towards a goal that won't be reached
            self.world.robot.drive(motion.rows, self.world.robot.positions()[motion.rows])
        self._tell_end(number, motion, end)
        self._say_held()

    def _tell_end(self, number: int, motion: Motion, end: Ended) -> None:
        said = {"error": end.error, "message": end.message, "data": {} if end.stopped else {"stopped": False}}
        self._send({"id": number, **self._measured(motion.rows), **said})

    def _brake(self, number: int) -> None:
        """Have a motion come to rest; in a pause nothing moves, so it ends at once, and comes to rest after that."""
        motion = self._motions[number].braking(self.world)
        if not self._frozen:
            self._motions[number] = motion
            return
        self._tell_end(number, self._motions.pop(number), Ended("canceled", "the motion was stopped in a pause"))
        self._motions[-abs(number)] = motion

    def _send(self, said: Answer) -> None:
        self._connection.sendall(pack({"time": self.world.time, **said}))

    # --- what may be called: `_call_` and the name of the call ---

    def _call_begin(self, number: int, spec: dict[str, Any]) -> None:
        self._begin(WorldSpec.from_json(spec))
        gc.collect()  # a world is full of circles, and its physics is large where Python sees little

    def _call_pause(self, number: int) -> None:
        """Let no time pass; what moves stays where it is, as it is."""
        self._frozen = True

    def _call_resume(self, number: int) -> None:
        self._frozen = False

    def _call_step(self, number: int, steps: int) -> None:
        """Let some steps of time pass in a pause."""
        if not self._frozen:
            raise GripError("single steps are for a world that is paused")
        for _ in range(steps):
            self._end_what_is_over()
            self._step()

    def _call_take_turns(self, number: int) -> None:
        self._in_turns, self._going = True, False

    def _call_go(self, number: int, until: float | None) -> None:
        """Go on up to a moment [s], or to the end of a motion."""
        self._until, self._going = until, True
        if not self._in_turns:  # the robot was told to hold
            self._call_stand()

    def _call_stand(self, number: int = 0) -> None:
        """Stand still, and say so behind everything that was said before."""
        if self._going:
            self._going = False
            self._send({"id": 0, "stands": True})

    def _call_go_freely(self, number: int) -> None:
        self._in_turns = self._going = False

    def _allow_motion(self) -> None:
        if self._held:
            raise GripError("the robot was stopped by the supervisor of this run; no further motion is accepted")

    def _call_follow(self, number: int, names: list[str], from_here: bool = False, **path: Array) -> None:
        self._allow_motion()
        robot, rows = self.world.robot, self.world.robot.rows(names)
        if from_here:
            now = robot.measure(rows)
            begins = {"positions": now.position, "velocities": now.velocity}
            path |= {part: np.vstack([begins[part], path[part][1:]]) for part in begins.keys() & path}
        motion = Follow(robot, rows, Trajectory(tuple(names), **path), self.world.time)
        self._replace(rows)
        robot.limit_torque(rows, None)
        self._motions[number] = motion
        if wrong := motion.wrong_start():
            self._finish(number, Ended("aborted", wrong))

    def _following(self, names: list[str]) -> Follow | None:
        rows = set(self.world.robot.rows(names))
        return next((m for m in self._motions.values() if isinstance(m, Follow) and set(m.rows) == rows), None)

    def _call_passed(self, number: int, names: list[str]) -> Answer:
        motion = self._following(names)
        return {"passed": None if motion is None else motion.passed(self.world.time)}

    def _call_amend(self, number: int, names: list[str], at: float, **path: Array) -> Answer:
        motion = self._following(names)
        return {"amended": motion is not None and motion.amend(self.world.time, at, **path)}

    def _call_move_hand(
        self, number: int, names: list[str], goal: Array, duration: float, limit: float | None, force: float | None
    ) -> None:
        self._allow_motion()
        robot, rows = self.world.robot, self.world.robot.rows(names)
        self._replace(rows)
        robot.limit_torque(rows, limit)
        robot.press(rows, force)
        self._motions[number] = MoveHand(robot, rows, goal, duration, self.world.time, force)

    def _call_wait(self, number: int, seconds: float | None) -> None:
        now = self.world.time
        self._motions[number] = ComeToRest(now) if seconds is None else Wait(now + seconds)

    def _call_stop(self, number: int, names: list[str]) -> None:
        for moving in self._moving(self.world.robot.rows(names)):
            self._brake(moving)

    def _call_cancel(self, number: int, motion: int) -> None:
        if motion in self._motions:
            self._brake(motion)

    def _moving(self, rows: Indices) -> list[int]:
        return [number for number, motion in self._motions.items() if np.intersect1d(motion.rows, rows).size]

    def _replace(self, rows: Indices) -> None:
        """End whatever moves one of these joints, for what takes its place."""
        for number in self._moving(rows):
            self._finish(number, Ended("canceled", "replaced by another motion"))

    def _call_state(self, number: int, names: list[str]) -> Answer:
        return self._measured(self.world.robot.rows(names))

    def _measured(self, rows: Indices) -> Answer:
        return self.world.robot.measure(rows)._asdict() if rows.size else {}

    def _call_feel(self, number: int, names: list[str], what: str) -> Answer:
        """Say what the hand of some joints feels."""
        if what not in ("hand_contacts", "contact_points", "slips", "link_wrenches", "wrench"):
            raise LookupError(f"nothing feels {what!r}")
        return {"felt": getattr(self.world, what)(self.world.robot.hand_of(int(self.world.robot.rows(names)[0])))}

    def _call_look(self, number: int, camera: str) -> Answer:
        frame = self.world.cameras.look(camera)
        age = self.world.time - frame.time
        return {"pose": _listed(frame.pose), "age": age, "image": frame.image, "depth": frame.depth}

    def _call_film(self, number: int, view: object, video: str | None, picture: str | None) -> None:
        self._call_end_film()
        camera = view if isinstance(view, str) else TypeAdapter(CameraSpec).validate_python(view)
        files = (None if file is None else Path(file) for file in (video, picture))
        self._film = Film(self.world.cameras, camera, self.world.time, *files)

    def _call_end_film(self, number: int = 0) -> None:
        film, self._film = self._film, None
        if film is not None:
            film.close()

    def _call_put_back(self, number: int, kept: dict[str, Array], cancel: bool) -> None:
        moving = [number for number, motion in self._motions.items() if motion.rows.size]
        if moving and not cancel:
            raise GripError("a world can only be restored while nothing moves")
        for each in moving:
            self._finish(each, Ended("canceled", "the world was put back"))
        self.world.put_back(kept)


def _listed(pose: Pose) -> list[float]:
    return [*pose.position.tolist(), *pose.quaternion.tolist()]


OF_WORLD: Mapping[str, Callable[..., Answer | None]] = {
    "move_object": lambda world, name, position, quaternion: world.move_object(name, Pose(position, quaternion)),
    "spawn": lambda world, spec: world.spawn(TypeAdapter(ObjectSpec).validate_python(spec)),
    "remove": World.remove,
    "inject": lambda world, name, fault: world.inject(name, Fault.model_validate(fault)),
    "entered": lambda world, node: world.faults.entered(node),
    "camera_pose": lambda world, camera: {"pose": _listed(world.cameras.pose(camera))},
    "truth": lambda world: {"truth": list(map(tuple, judge(world)))},
    "measures": lambda world: {"measures": world.measures()},
    "fingerprint": lambda world: {"fingerprint": world.fingerprint()},
    "kept": lambda world: {"kept": world.kept()},
}
"""Calls that ask the world alone, or change what is in it."""


def main() -> int:
    """Make the world that the client asks for and obey it."""
    # Ctrl-C reaches the whole process group; when to end is the client's decision, and its end is ours.
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    connection = socket.socket(fileno=int(sys.argv[1]))
    try:
        fields = receive(connection)
        hold = socket.socket(fileno=int(sys.argv[2])) if len(sys.argv) > 2 else None
        gc.freeze()  # what was imported is never looked through again
        server = Server(connection, WorldSpec.from_json(fields["spec"]), fields["pace"], hold)
        connection.sendall(pack({"id": fields["id"], "time": 0.0}))
    except (ClosedError, BrokenPipeError):
        return 0
    server.serve()
    os._exit(0)  # nothing is left to be saved, and taking the physics apart would take half a second


if __name__ == "__main__":
    sys.exit(main())
