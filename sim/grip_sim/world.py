"""One simulated world: a robot at a table with objects and a crate, stepped by whoever owns it."""

from __future__ import annotations

import hashlib
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import hypot
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.values import Pose
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.description.robot import RobotDescription
from grip_sim.articulated.bodies import make_articulated, moving, set_moving
from grip_sim.articulated.model import Vector
from grip_sim.cameras.looks import Target, visuals_of
from grip_sim.cameras.mesh_files import Look
from grip_sim.cameras.rig import Rig
from grip_sim.faults import Fault, Faults, check_faults
from grip_sim.liquids import Liquids
from grip_sim.objects import load_object
from grip_sim.physics import FIXED, SLIPPERY, SOLID, add_model, make_scene, movable, physx, sapien
from grip_sim.robot import SimRobot
from grip_sim.shaking import MEASURE, Lay, Shaking
from grip_sim.specs import SPILLED, VOLUME, BoxSpec, MeshSpec, ObjectSpec, WorldSpec
from grip_sim.touch import Slipping, wrist_wrench


class Contact(NamedTuple):
    """A body that touches another.

    Attributes:
        push: force on it along the surface's normal, without friction, in world [N].
    """

    body: str
    other: str
    push: Vector

    @property
    def force(self) -> float:
        """How hard they press on each other [N]."""
        return float(np.linalg.norm(self.push))


TOUCH = 1e-3
"""Contact forces below this are none [N]."""
FEELING, SELDOM, STEADY = 1 / 80, 8, 0.01
"""Interval at which a regulated force is felt [s], as asking for contacts takes as long as a step; and so many times
that while it is as it is to be, and has changed by less than this part of it."""
UPRIGHT = sapien.Pose(q=[np.sqrt(0.5), 0, np.sqrt(0.5), 0])
"""PhysX cylinders lie along x."""
FLOOR, FLOOR_SIZE, FLOOR_DEPTH, FLOOR_COLOUR = "floor", 20.0, 1.0, (92, 94, 98)
"""A block so thick that nothing falls through; lengths in m."""
ARM_COLOUR, HAND_COLOUR = (222, 222, 226), (52, 54, 60)


class World:
    """The physics of one spec. The same spec and the same sequence of calls give the same states, bit by bit.

    Args:
        description: the robot; by default the one that the spec names.
    """

    def __init__(self, spec: WorldSpec, description: RobotDescription | None = None):
        self.spec = spec
        self.scene = make_scene(spec.dt)
        self.physics: Callable[[], None] = self.scene.physx_system.step
        """Advances the bare scene."""
        under = (0.0, 0.0, spec.floor - FLOOR_DEPTH / 2)
        floor = BoxSpec(FLOOR, (FLOOR_SIZE, FLOOR_SIZE, FLOOR_DEPTH), under, FLOOR_COLOUR)
        fixtures: list[BoxSpec | MeshSpec] = [*spec.boxes, floor, *spec.meshes]
        still = [self._add_still(each) for each in fixtures]
        self.robot = SimRobot(self.scene, description or load_robot(spec.robot))
        self._own, self.links = frozenset(self.robot.links), {link.name: link for link in self.robot.links}
        check_names(spec, self.links)
        hands = self.robot.description.hands.items()
        self._fingers = {hand: {self.links[name] for name in names if name in self.links} for hand, names in hands}
        self._liquids = Liquids(self._underside, self._uprightness)
        self._objects = {o.name: self._add_object(o) for o in spec.objects}
        self.articulated = {
            name: make_articulated(self.scene, name, said, lambda *two: self.cameras.replaced(*two), self._liquids)
            for name, said in spec.articulated.items()
        }
        self._slipping = {hand: Slipping() for hand in self._fingers}
        self.steps = 0
        """How often it was advanced."""
        self._moved: dict[str, sapien.Entity] = {}  # SAPIEN goes on naming them in contacts, removed ones too
        self._felt = defaultdict[str, tuple[float, int]](lambda: (0.0, 0))
        """How hard hands press whose force is regulated [N], and the step with which that is felt again."""
        self._feeling = max(1, round(FEELING / spec.dt))
        self.faults = Faults(spec.faults, spec.seed, self)
        links = [Target(link, link.name, c) for each in self.articulated.values() for link, c in each.links.items()]
        seen = [*still, *self._robot_targets(), *map(self._object_target, spec.objects), *links]
        self._shaking = self._watch()
        self.cameras = Rig(self, seen)

    @property
    def time(self) -> float:
        """Simulated time since the world was made [s]."""
        return self.steps * self.spec.dt

    def step(self) -> None:
        """Advance by `spec.dt`."""
        if self.faults.due:
            self.faults.stepped()
        self.robot.follow()
        self.robot.compensate()
        for each in self.articulated.values():
            each.before_step()
        if self._liquids.volumes:
            self._liquids.settle()
        self.physics()
        self.steps = steps = self.steps + 1
        self._moved.clear()
        for hand, rows in self.robot.pressing.items():
            if steps >= self._felt[hand][1]:
                self._regulate(hand, rows)
        if self._shaking is not None and self.time >= self._shaking.due:
            self._shaking.look(self.time)
        if steps >= self.cameras.due:
            self.cameras.keep()

    def object_pose(self, name: str) -> Pose:
        """Return the pose of an object's centre in world."""
        return _pose(self._object(name).entity_pose)

    def object_speeds(self, name: str) -> tuple[float, float]:
        """Return how fast an object moves [m/s] and turns [rad/s]."""
        body = self._object(name)
        return float(np.linalg.norm(body.linear_velocity)), float(np.linalg.norm(body.angular_velocity))

    def move_object(self, name: str, pose: Pose) -> None:
        """Put an object elsewhere, at rest; for experiments that disturb a task."""
        body = self._object(name)
        set_moving(body, np.array([*pose.position, *pose.quaternion, *np.zeros(6)]))
        body.wake_up()
        self._moved[name] = body.entity
        self._felt.clear()

    def spawn(self, spec: ObjectSpec) -> None:
        """Add an object. Raises ValueError where something has its name."""
        check_names(replace(self.spec, objects=(*self.spec.objects, spec)), self.links)
        self.spec = replace(self.spec, objects=(*self.spec.objects, spec))
        self._objects[spec.name] = self._add_object(spec)
        self.cameras.show([*self.cameras.targets, self._object_target(spec)])

    def remove(self, name: str) -> None:
        """Take an object away. Raises UnknownNameError where there is no such object."""
        self._moved[name] = entity = self._object(name).entity
        entity.remove_from_scene()
        self._felt.clear()
        self.faults.forget(name)
        del self._objects[name]
        self._liquids.remove(name)
        self.spec = replace(self.spec, objects=tuple(each for each in self.spec.objects if each.name != name))
        self.cameras.show([each for each in self.cameras.targets if each.name != name])

    def inject(self, name: str, fault: Fault) -> None:
        """Have something go wrong from now on. Raises GripError where it names what isn't there, but for components."""
        robot, cameras = self.robot.description, [camera.name for camera in self.spec.cameras]
        for error in check_faults({name: fault}, robot, self._objects, cameras, [fault.of]):
            raise error
        self.faults.add(name, fault)
        self.cameras.remember(fault.lag or 0.0)

    def held_objects(self) -> list[str]:
        """Return the objects that a hand touches."""
        touched = {contact.body for contact in self.contacts() if contact.other in self.robot.hand_links}
        return [name for name in self._objects if name in touched]

    def let_slip(self, name: str, slips: bool) -> None:
        """Have an object pass through hands, or not any more."""
        body = self._object(name)
        for shape in body.collision_shapes:
            shape.set_collision_groups([*(SLIPPERY if slips else SOLID), *shape.get_collision_groups()[2:]])
        body.wake_up()

    def push(self, name: str, by: Vector) -> None:
        """Change an object's velocity [m/s]."""
        body = self._object(name)
        body.set_linear_velocity(np.add(body.linear_velocity, by))
        body.wake_up()

    def link_pose(self, name: str) -> Pose:
        """Return the pose of a robot's link in world."""
        if name not in self.links:
            raise UnknownNameError("link", name, self.links)
        return _pose(self.links[name].entity_pose)

    def contacts(self) -> Iterator[Contact]:
        """Yield the contacts of the last step that carry a force, of both bodies; of those moved since then none."""
        for contact in self.scene.get_contacts():
            one, two = (body.entity.name for body in contact.bodies)
            if self._force(contact) > TOUCH and self._moved.keys().isdisjoint((one, two)):
                x, y, z = (_impulse(contact) / self.spec.dt).tolist()
                yield from (Contact(one, two, (x, y, z)), Contact(two, one, (-x, -y, -z)))

    def hand_contacts(self, hand: str) -> Mapping[str, float]:
        """Return the contact force [N] of each link of a hand that touches something that isn't the robot."""
        forces: dict[str, float] = {}
        for link, _, contact in self._touching(hand):
            if (force := self._force(contact)) > TOUCH:
                forces[link.entity.name] = forces.get(link.entity.name, 0.0) + force
        return forces

    def contact_points(self, hand: str) -> list[tuple[str, str, list[float], list[float]]]:
        """Return where a hand presses: link, other body, position and force on that body, in world [m], [N]."""
        return [
            (link.entity.name, body.entity.name, point.position.tolist(), force.tolist())
            for link, body, contact in self._touching(hand)
            for point in contact.points
            for force in [point.impulse / (-self.spec.dt if contact.bodies[0] is link else self.spec.dt)]
            if np.linalg.norm(force) > TOUCH
        ]

    def slips(self, hand: str) -> Mapping[str, float]:
        """Return how fast something slides along each link of a hand [m/s]; see `touch.Slipping`."""
        return self._slipping[hand].speeds(self.time, self._holding(hand))

    def link_wrenches(self, hand: str) -> Mapping[str, Array]:
        """Return link -> what it bears from what isn't the robot: force [N], torque [N m], in its frame, shape (6,)."""
        links = (link for link in self.robot.links if link in self._fingers[hand] and link.collision_shapes)
        borne = {link.name: np.zeros(6) for link in links}
        for name, _, at, push in self.contact_points(hand):
            here, force = self.link_pose(name), -np.array(push)
            turned = np.stack([force, np.cross(at - here.position, force)]) @ here.rotation()
            borne[name] += turned.ravel()
        return borne

    def wrench(self, hand: str) -> Mapping[str, Array]:
        """Return what a hand bears from outside; see `touch.wrist_wrench`."""
        touching = {contact.body for contact in self.contacts()}
        return wrist_wrench(self.robot.body, self._fingers[hand], touching)

    def pressed(self, hand: str) -> float:
        """Return how hard a hand presses on objects [N], as felt last: half of all forces, as sides are opposed."""
        pressed, due = self._felt[hand]
        return pressed if self.steps < due and hand in self.robot.pressing else self._feel(hand)

    def _feel(self, hand: str) -> float:
        return sum(self._force(contact) for _, _, contact in self._holding(hand)) / 2

    def _regulate(self, hand: str, rows: Sequence[int]) -> None:
        before, pressed = self._felt[hand][0], self._feel(hand)
        steps = self._feeling if pressed else 1  # what isn't touched yet may be with any step
        if not self.robot.regulate(rows, pressed, steps * self.spec.dt) and abs(pressed - before) < STEADY * pressed:
            steps *= SELDOM
        self._felt[hand] = pressed, self.steps + steps

    def _force(self, contact: physx.PhysxContact) -> float:
        return hypot(*_impulse(contact).tolist()) / self.spec.dt

    def _holding(self, hand: str) -> Iterator[tuple[Any, Any, physx.PhysxContact]]:
        """Yield the contacts of a hand's links and what isn't fixed, with the link and the body."""
        return (each for each in self._touching(hand) if type(each[1]) is not physx.PhysxRigidStaticComponent)

    def _touching(self, hand: str) -> Iterator[tuple[Any, Any, physx.PhysxContact]]:
        """Yield the contacts of a hand's links with what isn't the robot, with the link and the body."""
        fingers, own, moved = self._fingers.get(hand, ()), self._own, self._moved
        for contact in self.scene.get_contacts():
            one, two = contact.bodies
            if (one in fingers) == (two in fingers):
                continue  # names take their time, and most contacts are of others
            link, body = (one, two) if one in fingers else (two, one)
            if body not in own and not (moved and body.entity.name in moved):
                yield link, body, contact

    def measures(self) -> dict[str, float]:
        """Return the numbers that the referee has besides those of objects; see `WorldSpec.measures`."""
        volumes = {VOLUME.format(name): volume for name, volume in self._liquids.volumes.items()}
        liquids = {**volumes, SPILLED: self._liquids.spilled} if volumes else {}
        shaken = {} if self._shaking is None else {MEASURE: float(self._shaking.count)}
        own = {f"{name}_{key}": n for name, each in self.articulated.items() for key, n in each.measures().items()}
        return own | liquids | shaken

    def kept(self) -> dict[str, Array]:
        """Return everything that moves, and how: the robot, and the poses and velocities of the objects."""
        bodies = list(self._objects.values())
        states = np.array([moving(body) for body in bodies]).reshape(-1, 13)
        articulated = {f"articulated.{name}": each.kept() for name, each in self.articulated.items()}
        loose = {"poses": states[:, :7], "object_speeds": states[:, 7:], "liquids": self._liquids.kept()}
        return {**self.robot.kept(), **loose, **articulated}

    def put_back(self, kept: Mapping[str, Array]) -> None:
        """Bring everything that moves to where it was kept; what physics remembers of contacts builds up again.

        Raises KeyError or ValueError, before anything is changed, where it was kept in another world.
        """
        poses, speeds = np.asarray(kept["poses"]), np.asarray(kept["object_speeds"])
        if len(poses) != len(self._objects):
            raise ValueError(f"the state is of another world: this one has {len(self._objects)} objects")
        states = {name: kept[f"articulated.{name}"] for name in self.articulated}
        volumes = kept["liquids"]
        self.robot.put_back(kept)
        self._shaking = self._watch()
        self._felt.clear()
        self.cameras.forget()
        self._liquids.put_back(volumes)
        for name, state in states.items():
            self.articulated[name].put_back(state)
        for body, pose, speed in zip(self._objects.values(), poses, speeds, strict=True):
            set_moving(body, np.concatenate([pose, speed]))
            body.wake_up()

    def fingerprint(self) -> str:
        """Return a hash over everything that moves."""
        state = np.concatenate([np.ravel(part) for part in self.kept().values()])
        return hashlib.sha256(state.astype(np.float32).tobytes()).hexdigest()

    def _watch(self) -> Shaking | None:
        if self.spec.shake is None:
            return None
        palm = self.links[self.robot.description.grasp_frame.link]
        return Shaking(self.spec.shake, lambda: palm.entity_pose.p, lambda: self._seen_from(palm.entity_pose.inv()))

    def _seen_from(self, place: sapien.Pose) -> dict[str, Lay]:
        seen = {name: place * body.entity_pose for name, body in self._objects.items()}
        return {name: (pose.p.tolist(), pose.q.tolist()) for name, pose in seen.items()}

    def _object(self, name: str) -> physx.PhysxRigidDynamicComponent:
        if name not in self._objects:
            raise UnknownNameError("object", name, self._objects)
        return self._objects[name]

    def _add_still(self, spec: BoxSpec | MeshSpec) -> Target:
        builder = self.scene.create_actor_builder()
        if isinstance(spec, BoxSpec):
            builder.add_box_collision(half_size=[s / 2 for s in spec.size], material=FIXED)
        else:
            builder.add_nonconvex_collision_from_file(spec.file, scale=[spec.scale] * 3, material=FIXED)
        builder.set_physx_body_type("static")
        builder.set_initial_pose(sapien.Pose(spec.pose.position, spec.pose.quaternion))
        body = builder.build(name=spec.name).find_component_by_type(physx.PhysxRigidStaticComponent)
        return Target(body, spec.name, spec.colour)

    def _underside(self, name: str) -> Pose:
        """Return the pose of the middle of an object's underside in world."""
        height = next(spec.height for spec in self.spec.objects if spec.name == name)
        return self.object_pose(name) @ Pose((0.0, 0.0, -height / 2))

    def _uprightness(self, name: str) -> float:
        _, x, y, _ = self._objects[name].entity_pose.q
        return 1 - 2 * float(x * x + y * y)

    def _add_object(self, spec: ObjectSpec) -> physx.PhysxRigidDynamicComponent:
        if spec.vessel is not None:
            self._liquids.add(spec.name, spec.vessel)
        if spec.shape == "model":
            return add_model(self.scene, spec, load_object(Path(spec.model)))
        builder = self.scene.create_actor_builder()
        material = movable(spec.friction)
        r, h = spec.radius, spec.height
        if spec.shape == "cylinder":
            builder.add_cylinder_collision(UPRIGHT, r, h / 2, material, spec.mass / (np.pi * r * r * h))
        elif spec.shape == "sphere":
            builder.add_sphere_collision(radius=r, material=material, density=spec.mass / (4 / 3 * np.pi * r**3))
        else:
            density = spec.mass / (4 * r * r * h)
            builder.add_box_collision(half_size=[r, r, h / 2], material=material, density=density)
        builder.set_initial_pose(sapien.Pose(spec.pose.position, spec.pose.quaternion))
        entity = builder.build(name=spec.name)
        return entity.find_component_by_type(physx.PhysxRigidDynamicComponent)

    def _robot_targets(self) -> Iterator[Target]:
        visuals = visuals_of(self.robot.description.urdf)
        for link in self.robot.links:
            if link.collision_shapes or link.name in visuals:
                hand = link.name in self.robot.hand_links
                colour = HAND_COLOUR if hand else ARM_COLOUR
                yield Target(link, link.name, colour, visuals.get(link.name))

    def _object_target(self, spec: ObjectSpec) -> Target:
        def looks() -> list[Look]:
            return [look.moved(np.eye(4), spec.scale) for look in load_object(Path(spec.model)).looks]

        visuals = looks if spec.shape == "model" else None
        return Target(self._objects[spec.name], spec.name, spec.colour, visuals)


def check_names(spec: WorldSpec, links: Iterable[str]) -> None:
    """Raise ValueError when two things of a world have one name: contacts and images tell them apart by it."""
    fixtures = (*(box.name for box in spec.boxes), *(mesh.name for mesh in spec.meshes))
    names = [*links, FLOOR, *fixtures, *(thing.name for thing in spec.objects), *spec.articulated]
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice:
        raise ValueError(f"a world's objects, boxes and links need names of their own; more than one is {twice[0]!r}")


def _impulse(contact: physx.PhysxContact) -> Array:
    points = contact.points
    impulse = points[0].impulse
    for point in points[1:]:
        impulse = impulse + point.impulse
    return impulse


def _pose(pose: sapien.Pose) -> Pose:
    return Pose(pose.p, pose.q)
