"""Our planning scene, kept in move_group's: what changed since the last request is sent before the next one.

What a task allows to touch and forbids again is as it was before: pairs that the robot's SRDF allows stay allowed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from grip_bt.base.failures import GoalRejectedError, PlannerLostError, ServerLostError
from grip_bt.base.operation import Operation
from grip_bt.base.steps import Steps
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.tree import Tree
from grip_bt.commanders.scene_state import ANYTHING, SceneObject, SceneSnapshot

from ..client.types import Message, load_type
from .client import MoveGroup
from .goals import REMOVE, ArmMapping, collision_object, removed

_EMPTY = SceneSnapshot()


class PlanningSceneSync:
    """Sends changes of a scene. One request at a time; see `grip_bt.base.steps.Sequencer`.

    What others put into move_group's scene is left alone; what was sent is taken out again by `clear`.

    Args:
        robot: whose base link is world, and whose links may be allowed to touch.
        mounts: hand, as the scene knows it -> where it sits.
    """

    def __init__(self, move_group: MoveGroup, robot: RobotDescription, mounts: Mapping[str, ArmMapping]):
        self._move_group, self._mounts, self._frame = move_group, dict(mounts), robot.base_link
        self._links = Tree.of(robot.urdf).links
        self._sent = _EMPTY
        self._baseline: Any = None
        self._server: frozenset[bytes] = frozenset()

    def show(self, scene: SceneSnapshot) -> Steps[None]:
        """Have move_group's scene be `scene`; ends with GoalRejectedError when it doesn't take it."""
        try:
            yield from self._send(scene)
        except PlannerLostError as error:
            if not self._server or error.data.get("cause") != ServerLostError.code:
                raise
            # Who had the request is gone; one that was started in its place may be there, and gets everything.
            self._sent, self._baseline, self._server = _EMPTY, None, frozenset()
            yield from self._send(scene)
        if self._server != self._move_group.scene_server:
            # Another move_group answered than the one that has the earlier changes: it gets everything.
            self._server, self._sent, self._baseline = self._move_group.scene_server, _EMPTY, None
            yield from self._send(scene)

    def clear(self) -> Steps[None]:
        """Take out what was sent; a move_group that is gone has forgotten it anyway."""
        if self._baseline is None:
            return
        try:
            yield from self._send(_EMPTY)
        except (PlannerLostError, ServerLostError):
            return

    def _send(self, scene: SceneSnapshot) -> Steps[None]:
        if self._baseline is None:
            self._baseline = yield self._move_group.allowed_collisions()
        yield self._apply(self._difference(scene))  # also without a difference: the answer shows whose scene it is
        self._sent = scene
        self._server = self._server or self._move_group.scene_server

    def _apply(self, diff: Message) -> Operation[None]:
        def check(answer: Message) -> Operation[None]:
            if answer.success:
                return Operation.finished(None)
            names = [o.id for o in diff.world.collision_objects]
            reason = f"{self._move_group.name} rejected the planning scene: {', '.join(names) or 'allowed collisions'}"
            return Operation.failed(GoalRejectedError(f"{reason}; its log tells why", objects=names))

        return self._move_group.apply(diff).then(check)

    def _difference(self, scene: SceneSnapshot) -> Message:
        """Return what turns the scene that was sent into `scene`."""
        before, now = self._sent.objects, scene.objects
        gone = [before[name] for name in before if name not in now]
        changed = [item for name, item in now.items() if before.get(name) != item]
        diff = load_type("moveit_msgs/msg/PlanningScene")(is_diff=True)
        diff.robot_state.is_diff = True
        for item in [*gone, *(before[item.name] for item in changed if item.name in before)]:
            if item.hand:  # MoveIt puts what is taken off a hand into the world, to be replaced or removed
                off = load_type("moveit_msgs/msg/AttachedCollisionObject")(link_name=self._mounts[item.hand].link)
                off.object.id, off.object.operation = item.name, REMOVE
                diff.robot_state.attached_collision_objects.append(off)
        for item in changed:
            if item.hand:
                diff.robot_state.attached_collision_objects.append(self._attached(item))
                if item.name in before and not before[item.name].hand:
                    diff.world.collision_objects.append(removed(item.name))
            else:
                diff.world.collision_objects.append(collision_object(item.name, item.shape, item.pose, self._frame))
        diff.world.collision_objects.extend(removed(item.name) for item in gone)
        if scene.allowed != self._sent.allowed or (scene.allowed and set(before) != set(now)):
            names = [*self._links, *now]
            diff.allowed_collision_matrix = with_allowed(self._baseline, sorted(scene.allowed), names)
        return diff

    def _attached(self, item: SceneObject) -> Message:
        mount = self._mounts[item.hand]
        return load_type("moveit_msgs/msg/AttachedCollisionObject")(
            link_name=mount.link,
            object=collision_object(item.name, item.shape, mount.frame @ item.pose, mount.link),
            touch_links=list(mount.hand_links),
        )


def with_allowed(baseline: Message, pairs: Iterable[tuple[str, str]], names: Iterable[str]) -> Message:
    """Return a matrix that allows `pairs` besides what `baseline` does.

    Args:
        baseline: a `moveit_msgs/msg/AllowedCollisionMatrix`; left as it is.
        pairs: of names of links and objects; `*` stands for all.
        names: further names of links and objects, for `*`.
    """
    pairs = list(pairs)
    known = list(dict.fromkeys([*baseline.entry_names, *names, *(n for p in pairs for n in p if n != ANYTHING)]))
    both = [*pairs, *((other, one) for one, other in pairs)]
    rows = {name: row.enabled for name, row in zip(baseline.entry_names, baseline.entry_values, strict=False)}
    column = {name: i for i, name in enumerate(baseline.entry_names)}
    default = dict(zip(baseline.default_entry_names, baseline.default_entry_values, strict=False))

    def may(one: str, other: str) -> bool:
        if any(a in (ANYTHING, one) and b in (ANYTHING, other) for a, b in both):
            return True
        if one in rows and other in column:
            return bool(rows[one][column[other]])
        said = [default[name] for name in (one, other) if name in default]
        return bool(said) and all(said)

    entry = load_type("moveit_msgs/msg/AllowedCollisionEntry")
    return load_type("moveit_msgs/msg/AllowedCollisionMatrix")(
        entry_names=known,
        entry_values=[entry(enabled=[may(one, other) for other in known]) for one in known],
        default_entry_names=list(baseline.default_entry_names),
        default_entry_values=list(baseline.default_entry_values),
    )
