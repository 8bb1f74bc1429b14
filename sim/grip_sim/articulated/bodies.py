"""The physics of articulated objects.

SAPIEN knows neither screws nor dry friction. Friction is a drive to rest whose force is limited, which the solver
treats as Coulomb's. A screw is a slide and a turn: the slide's stiff drive aims at where the turn has it, and what the
slide bears goes back to the turn as a torque, so that both move each other and the thread locks itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import Pose
from grip_sim.liquids import Liquids
from grip_sim.physics import FIXED, LinkBuilder, ignore_each_other, movable, physx, sapien
from grip_sim.specs import Colour, upright

from .model import WALL, ArticulatedConfig, ButtonConfig, DrawerConfig, PipetteConfig, ScrewBottleConfig

ALONG_Z = sapien.Pose(q=[np.sqrt(0.5), 0, -np.sqrt(0.5), 0])
"""Turns x, along which joints and cylinders lie, to z."""
BACKWARDS = sapien.Pose(q=[0, 0, 0, 1])
"""Turns x to -x."""
DOWNWARDS = sapien.Pose(q=[np.sqrt(0.5), 0, np.sqrt(0.5), 0])
GRIP = 1.0
"""Coefficient of friction of what is grasped: bars and caps."""
OWN, STIFF, DAMPED = 11, 1e6, 2e3
"""Bit of links that pass through one another; drive of a thread [N/m, N s/m], of which 1 kg of armature is a part."""
KEY_ARMATURE = 0.1
"""A key's and a plunger's inertia [kg]: with less, a step would carry a key past the click, and springs be too weak."""
GAP, BAR_AT, BAR_LENGTH = 0.002, 0.045, 0.1
"""Of a drawer: around it; of the middle of its bar from its front; of the bar [m]."""
COLLAR = 0.01
"""How far a pipette's collar reaches beyond its handle [m]."""
FRONT, METAL, RED, GLASS, BLUE = (186, 146, 100), (120, 122, 128), (196, 44, 40), (150, 190, 200), (40, 90, 180)
WHITE = (235, 235, 238)


class Articulated:
    """An articulated object in a scene."""

    body: physx.PhysxArticulation
    links: Mapping[physx.PhysxRigidBodyComponent, Colour]
    own: tuple[str, ...] = ()
    """Attributes, numbers, that are kept besides joints and the root."""

    def before_step(self) -> None:
        """Apply what its joints do by themselves."""

    def measures(self) -> Mapping[str, float]:
        """Return the numbers that the referee has of it, without its name: such as `opened` [m]."""
        return {}

    def kept(self) -> Array:
        """Return all that makes it go on as it does, as numbers."""
        root = self.body.links[0]
        return np.concatenate([self.body.get_qpos(), self.body.get_qvel(), moving(root), self.extra()])

    def put_back(self, kept: Array) -> None:
        """Bring it to where it was kept."""
        count = len(self.body.active_joints)
        self.body.set_qpos(np.float32(kept[:count]))
        self.body.set_qvel(np.float32(kept[count : 2 * count]))
        root = kept[2 * count :]
        self.body.set_root_pose(sapien.Pose(root[:3], root[3:7]))
        self.body.set_root_linear_velocity(root[7:10])
        self.body.set_root_angular_velocity(root[10:13])
        self.put_back_extra(root[13:])

    def extra(self) -> Array:
        """Return what is kept besides joints and the root."""
        return np.array([getattr(self, name) for name in self.own], float)

    def put_back_extra(self, extra: Array) -> None:
        """Bring that back."""
        for name, number in zip(self.own, extra.tolist(), strict=True):
            setattr(self, name, number)


def moving(body: physx.PhysxRigidBodyComponent) -> Array:
    """Return where a body is and how it moves: position, quaternion w x y z, velocity, turning rate."""
    pose = body.entity_pose
    return np.array([*pose.p, *pose.q, *body.linear_velocity, *body.angular_velocity], float)


def set_moving(body: physx.PhysxRigidDynamicComponent, state: Array) -> None:
    """Have a body be where it was and move as it did; see `moving`."""
    body.set_entity_pose(sapien.Pose(state[:3], state[3:7]))
    body.set_linear_velocity(state[7:10])
    body.set_angular_velocity(state[10:13])


Replaced = Callable[[physx.PhysxRigidBodyComponent, physx.PhysxRigidBodyComponent], None]
"""Told of a link whose place another body takes."""


def make_articulated(
    scene: sapien.Scene, name: str, said: ArticulatedConfig, replaced: Replaced, liquids: Liquids
) -> Articulated:
    """Put an articulated object into a scene."""
    pose = upright(said.at, said.yaw)
    if said.drawer is not None:
        return _Drawer(scene, name, said.drawer, pose)
    if said.button is not None:
        return _Button(scene, name, said.button, pose)
    if said.pipette is not None:
        return _Pipette(scene, name, said.pipette, pose, liquids)
    assert said.screw_bottle is not None, "the file was checked"
    return _ScrewBottle(scene, name, said.screw_bottle, pose, replaced)


Shape = Callable[[LinkBuilder], None]
Builder: TypeAlias = "LinkBuilder | sapien.ActorBuilder"


def _build(
    scene: sapien.Scene,
    pose: Pose,
    links: Mapping[str, tuple[str, tuple[float, float], sapien.Pose, Shape]],
    fixed: bool,
) -> physx.PhysxArticulation:
    """Return a chain of links; each has the kind, limits and axis of its joint to the one before, and a shape."""
    builder = scene.create_articulation_builder()
    parent: LinkBuilder | None = None
    for name, (kind, limits, axis, shape) in links.items():
        link = builder.create_link_builder(parent)
        link.set_name(name)
        if parent is not None:
            link.set_joint_name(f"{name}_joint")
            link.set_joint_properties(kind, [limits], axis, axis)
        shape(link)
        parent = link
    builder.set_initial_pose(sapien.Pose(pose.position, pose.quaternion))
    body = builder.build(fix_root_link=fixed)
    body.set_solver_position_iterations(32)
    body.set_solver_velocity_iterations(1)
    body.set_qpos(body.get_qpos())  # else links are at the origin before the first step
    for joint in body.active_joints:
        joint.set_friction(0.0)
    for link in body.links:
        link.set_linear_damping(0.0)
        link.set_angular_damping(0.0)
    ignore_each_other([shape for link in body.links for shape in link.collision_shapes], OWN)
    return body


def _calm(stiffness: float) -> float:
    """Return the damping with which a key or a plunger comes back without swinging [N s/m]."""
    return 2 * float(np.sqrt(stiffness * KEY_ARMATURE))


def _light(mass: float) -> Shape:
    return lambda link: link.set_mass_and_inertia(mass, sapien.Pose(), [mass * 1e-4] * 3)


class _Drawer(Articulated):
    def __init__(self, scene: sapien.Scene, name: str, said: DrawerConfig, pose: Pose):
        depth, width, height = said.size
        inner, wide, high = depth - WALL, width - 2 * WALL - 2 * GAP, height - 2 * WALL - 2 * GAP
        thin = WALL / 2
        side, level = (wide - thin) / 2, WALL + GAP + 0.3 * high
        plates = [
            ((thin, width, height), (-depth / 2 - thin / 2 - GAP, 0, height / 2)),
            ((inner, wide, thin), (-WALL / 2, 0, WALL + GAP + thin / 2)),
            ((thin, wide, 0.6 * high), (inner / 2 - WALL, 0, level)),
            *(((inner, thin, 0.6 * high), (-WALL / 2, y, level)) for y in (side, -side)),
        ]
        front, middle, end = -depth / 2 - thin - GAP, height / 2, BAR_LENGTH / 2
        handle = [
            ((said.bar, BAR_LENGTH, said.bar), (front - BAR_AT, 0, middle)),
            *(((BAR_AT, said.bar, said.bar), (front - BAR_AT / 2, y, middle)) for y in (end, -end)),
        ]

        def shape(link: LinkBuilder) -> None:
            for boxes, material in ((plates, movable(0.5)), (handle, movable(GRIP))):
                for size, at in boxes:
                    link.add_box_collision(sapien.Pose(at), [edge / 2 for edge in size], material)
            link.set_mass_and_inertia(said.mass, sapien.Pose([0, 0, height / 2]), [said.mass * 0.01] * 3)

        moving = f"{name}_drawer"
        links = {f"{name}_rail": ("", (0.0, 0.0), sapien.Pose(), _light(1.0))}
        self.body = _build(scene, pose, {**links, moving: ("prismatic", (0.0, said.travel), BACKWARDS, shape)}, True)
        self.links = {self.body.links[1]: FRONT}
        (joint,) = self.body.active_joints
        joint.set_drive_properties(0.0, 1e4, force_limit=said.friction, mode="force")
        joint.set_drive_velocity_target(0.0)

    def measures(self) -> Mapping[str, float]:
        return {"opened": float(self.body.get_qpos()[0])}


class _Button(Articulated):
    """Its force rises to the click, falls behind it to two fifths of that, and rises again."""

    own = ("_pressed", "_count")

    def __init__(self, scene: sapien.Scene, name: str, said: ButtonConfig, pose: Pose):
        self._said, self._pressed, self._count = said, False, 0
        r, t = said.radius, said.travel
        edge = 1.5 * r

        def base(link: LinkBuilder) -> None:
            link.add_box_collision(sapien.Pose([0, 0, 0.01]), [edge, edge, 0.01], FIXED)

        def key(link: LinkBuilder) -> None:
            middle = sapien.Pose([0, 0, 0.02 + t / 2 + 0.0035], ALONG_Z.q)
            link.add_cylinder_collision(middle, r, t / 2 + 0.0035, movable(GRIP))
            link.set_mass_and_inertia(0.01, sapien.Pose([0, 0, 0.025]), [1e-6] * 3)

        links = {
            f"{name}_base": ("", (0.0, 0.0), sapien.Pose(), base),
            f"{name}_key": ("prismatic", (0.0, t), DOWNWARDS, key),
        }
        self.body = _build(scene, pose, links, True)
        self.links = {self.body.links[0]: METAL, self.body.links[1]: RED}
        (self._joint,) = self.body.active_joints
        self._joint.set_armature(np.array([KEY_ARMATURE], np.float32))
        self._damping = _calm(0.85 * said.force / (0.4 * t))

    def before_step(self) -> None:
        """Press back: rising parts are an implicit spring, the falling one is a force, since no spring is unstable."""
        depth, force, travel = float(self.body.get_qpos()[0]), self._said.force, self._said.travel
        click, low = 0.4 * travel, 0.55 * travel
        if depth < click:
            stiffness, aim = 0.85 * force / click, -0.15 * force / (0.85 * force / click)
            self._spring(stiffness, aim, 0.0)
        elif depth < low:
            self._spring(0.0, 0.0, force * (1 - 0.6 * (depth - click) / (low - click)))
        else:
            stiffness = 1.2 * force / (travel - low)
            self._spring(stiffness, low - 0.4 * force / stiffness, 0.0)
        if self._pressed and depth < travel / 3:
            self._pressed = False
        elif not self._pressed and depth > travel * 2 / 3:
            self._pressed, self._count = True, self._count + 1

    def _spring(self, stiffness: float, aim: float, against: float) -> None:
        self._joint.set_drive_properties(stiffness, self._damping, force_limit=100.0, mode="force")
        self._joint.set_drive_target(aim)
        weight = self.body.compute_passive_force(True, True)
        self.body.set_qf(np.float32(weight - [against]))

    def measures(self) -> Mapping[str, float]:
        return {"presses": float(self._count)}


def _add_cylinder(builder: Builder, radius: float, height: float, mass: float, middle: float) -> None:
    """Add an upright cylinder of a mass [kg] whose middle is at a height [m]."""
    place, density = sapien.Pose([0, 0, middle], ALONG_Z.q), mass / (np.pi * radius**2 * height)
    builder.add_cylinder_collision(place, radius, height / 2, movable(GRIP), density=density)


class _ScrewBottle(Articulated):
    """A bottle, a slide and a cap; when the thread lets go, a body of its own takes the cap's place."""

    def __init__(self, scene: sapien.Scene, name: str, said: ScrewBottleConfig, pose: Pose, replaced: Replaced):
        self._scene, self._name, self._said, self._replaced = scene, name, said, replaced
        self._lift, self._middle = said.pitch / (2 * np.pi), said.height + said.cap_height / 2 + 0.001
        self._free: physx.PhysxRigidDynamicComponent | None = None
        travel = said.pitch * said.turns

        def bottle(link: LinkBuilder) -> None:
            _add_cylinder(link, said.radius, said.height, said.mass, said.height / 2)

        links = {
            name: ("", (0.0, 0.0), sapien.Pose(), bottle),
            f"{name}_thread": ("prismatic", (0.0, travel + 0.001), ALONG_Z, _light(0.002)),
            f"{name}_cap": ("revolute_unwrapped", (-0.001, 2 * np.pi * said.turns + 1), ALONG_Z, self._shape_cap),
        }
        self.body = _build(scene, pose, links, said.held)
        self._cap, self._stood = self.body.links[2], self.body.links[0].entity_pose
        self.links = {self.body.links[0]: GLASS, self._cap: BLUE}
        self._slide, self._turn = self.body.active_joints
        self._slide.set_armature(np.array([1.0], np.float32))
        self._slide.set_drive_properties(STIFF, DAMPED, force_limit=1e5, mode="force")
        self._turn.set_armature(np.array([2e-6], np.float32))
        self._turn.set_drive_properties(0.0, 50.0, force_limit=said.friction, mode="force")
        self._turn.set_drive_velocity_target(0.0)

    def _shape_cap(self, builder: Builder) -> None:
        said = self._said
        _add_cylinder(builder, said.cap_radius, said.cap_height, said.cap_mass, self._middle)

    def before_step(self) -> None:
        """Couple the slide and the turn, both ways; let the cap go at the end of its thread."""
        if self._free is not None:
            return
        angle, speed = float(self.body.get_qpos()[1]), float(self.body.get_qvel()[1])
        self._slide.set_drive_target(self._lift * (angle + speed * self._scene.get_timestep()))
        self._slide.set_drive_velocity_target(self._lift * speed)
        borne = float(self.body.get_link_incoming_joint_forces()[1][0])
        self.body.set_qf(np.array([0.0, -self._lift * borne], np.float32))
        if angle > 2 * np.pi * self._said.turns:
            self._let_go()

    def _let_go(self) -> None:
        builder = self._scene.create_actor_builder()
        self._shape_cap(builder)
        builder.set_initial_pose(self._cap.entity_pose)
        free = builder.build(name=f"{self._name}_cap").find_component_by_type(physx.PhysxRigidDynamicComponent)
        free.set_linear_velocity(self._cap.linear_velocity)
        free.set_angular_velocity(self._cap.angular_velocity)
        for shape in self._cap.collision_shapes:  # the articulation's cap stays, and touches nothing any more
            shape.set_collision_groups([0, 0, *shape.get_collision_groups()[2:]])
        self._cap.set_mass(1e-4)
        self._free = free
        self._replaced(self._cap, free)

    def measures(self) -> Mapping[str, float]:
        turns = float(self.body.get_qpos()[1]) / (2 * np.pi) if self._free is None else self._said.turns
        away, middle = self._stood.inv() * self.body.links[0].entity_pose, sapien.Pose([0.0, 0.0, self._middle])
        twisted = 2 * float(np.arctan2(np.linalg.norm(away.q[1:]), abs(away.q[0])))
        rise = float(((self._free or self._cap).entity_pose * middle).p[2] - (self._stood * middle).p[2])
        moved = {"slid": float(np.linalg.norm(away.p)), "twisted": twisted, "rise": rise}
        return {"turns": turns, "off": float(self._free is not None), **moved}

    def extra(self) -> Array:
        return np.zeros(0) if self._free is None else moving(self._free)

    def put_back_extra(self, extra: Array) -> None:
        if len(extra) and self._free is None:
            self._let_go()
        if self._free is not None:
            set_moving(self._free, extra)


class _Pipette(Articulated):
    """A handle with a shaft below, a collar that lies on a finger, and a plunger that a spring presses up."""

    own = ("_pressed", "_holds", "_air")

    def __init__(self, scene: sapien.Scene, name: str, said: PipetteConfig, pose: Pose, liquids: Liquids):
        self._said, self._liquids = said, liquids
        self._pressed = self._holds = self._air = 0.0
        collar, r = said.shaft + said.handle, said.radius
        top, narrow = collar + said.neck, said.shaft / 3

        def body(link: LinkBuilder) -> None:
            for radius, low, high, part in (
                (0.003, 0.0, narrow, 0.05),
                (0.006, narrow, said.shaft, 0.15),
                (r, said.shaft, collar, 0.7),
                (r + COLLAR, collar - 0.006, collar, 0.05),
                (0.6 * r, collar, top, 0.05),
            ):
                _add_cylinder(link, radius, high - low, part * said.mass, (low + high) / 2)

        def plunger(link: LinkBuilder) -> None:
            _add_cylinder(link, 0.7 * r, 0.006, 0.004, top + said.travel + 0.003)
            _add_cylinder(link, 0.004, said.travel, 0.002, top + said.travel / 2)

        links = {
            name: ("", (0.0, 0.0), sapien.Pose(), body),
            f"{name}_plunger": ("prismatic", (0.0, said.travel), DOWNWARDS, plunger),
        }
        self.body = _build(scene, pose, links, False)
        self.links = {self.body.links[0]: WHITE, self.body.links[1]: BLUE}
        stiffness = 0.6 * said.force / said.travel
        (joint,) = self.body.active_joints
        joint.set_armature(np.array([KEY_ARMATURE], np.float32))
        joint.set_drive_properties(stiffness, _calm(stiffness), force_limit=100.0, mode="force")
        joint.set_drive_target(-0.4 * said.force / stiffness)

    def before_step(self) -> None:
        """Draw or release what the plunger's way since the last step makes room for, or takes the room of."""
        pressed = min(max(float(self.body.get_qpos()[0]) / self._said.travel, 0.0), 1.0)
        volume, self._pressed = (pressed - self._pressed) * self._said.volume, pressed
        tip = np.array(self.body.links[0].entity_pose.p, float)
        if volume < 0:
            drawn = self._liquids.draw(tip, -volume)
            self._holds += drawn
            self._air += -volume - drawn if self._holds else 0.0
        elif self._holds:
            air = min(volume, self._air)
            released = min(volume - air, self._holds)
            self._liquids.release(tip, released)
            self._holds -= released
            self._air = self._air - air if self._holds else 0.0

    def measures(self) -> Mapping[str, float]:
        return {"pressed": self._pressed, "holds": self._holds}
