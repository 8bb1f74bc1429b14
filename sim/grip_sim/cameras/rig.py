"""The cameras of a world: where they are, who draws for them, what their sensors add, and how late; films of it."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING
from zlib import crc32

import cv2
import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.values import Pose
from grip_sim.cameras import Frame, Places, Renderer, vulkan_works
from grip_sim.cameras.looks import Target
from grip_sim.cameras.raster import RasterRenderer
from grip_sim.faults import darkened
from grip_sim.physics import physx
from grip_sim.specs import CameraSpec

if TYPE_CHECKING:  # which makes the rig
    from grip_sim.world import World

APART = 1 / 60
"""Interval at which late cameras take frames, for which it is kept where everything is [s]; so much later at most."""


class Rig:
    """Takes frames of bodies. Raises UnknownNameError where a camera is on a link that the robot doesn't have."""

    def __init__(self, world: World, targets: Sequence[Target]):
        self._world, self._last, self._pack = world, dict[str, Frame](), world.scene.pack_poses
        spec, links = world.spec, world.links
        self._specs = {camera.name: camera for camera in spec.cameras}
        carriers = dict.fromkeys(camera.link for camera in spec.cameras if camera.link is not None)
        for name in carriers.keys() - links.keys():
            raise UnknownNameError("link", name, links, "a camera's `link`")
        self._carriers = {name: links[name] for name in carriers}
        self._taken = dict.fromkeys(self._specs, 0)
        self._renderers: dict[CameraSpec, Renderer] = {}
        self._latency = max((camera.noise.latency for camera in spec.cameras if camera.noise is not None), default=0.0)
        self._past: deque[tuple[int, bytes]] = deque(maxlen=0)
        """Where everything was, after some of the last steps."""
        self._dt, self._apart = spec.dt, max(1, int(APART / spec.dt + 1e-6))
        self.due = np.inf
        """The step after which that is kept again."""
        self.remember(max((fault.lag or 0.0 for fault in spec.faults.values()), default=0.0))
        self.show(targets)

    def remember(self, lag: float) -> None:
        """Keep where everything was for frames that a fault makes so late [s], on top of what sensors do."""
        late = self._latency + lag
        count = int(np.ceil(late / self._dt / self._apart)) + 2 if late else 0
        if count > (self._past.maxlen or 0):
            self._past, self.due = deque(self._past, count), min(self.due, self._world.steps)

    def show(self, targets: Sequence[Target]) -> None:
        """See these bodies from now on, in place of all others."""
        self.targets = tuple(targets)
        self._rows = {name: len(targets) + i for i, name in enumerate(self._carriers)}
        self._renderers.clear()
        places = {entity: row for row, entity in enumerate(self._world.scene.entities)}
        self._places = [places[b.entity] for b in (*(each.body for each in self.targets), *self._carriers.values())]
        self.forget()

    def replaced(self, old: physx.PhysxRigidBaseComponent, new: physx.PhysxRigidBaseComponent) -> None:
        """Show a body where another of the same shape is from now on."""
        self.show([replace(each, body=new) if each.body is old else each for each in self.targets])

    def forget(self) -> None:
        """Show nothing of what was before, however late a camera is."""
        self._past.clear()

    def keep(self) -> None:
        """Keep where everything is, for cameras that show it late; when it is due."""
        now = self._world.steps
        self._past.append((now, self._pack()))
        self.due = now + self._apart

    def look(self, name: str) -> Frame:
        """Take a frame with a camera, as its sensor gives it. Raises UnknownNameError where there is no such camera."""
        spec = self._spec(name)
        if self._world.faults.of_camera("freeze", name) and name in self._last:
            return replace(self._last[name], time=self._world.time)
        late = self._world.faults.of_camera("late", name)
        frame = self._sensed(spec, 0.0 if late is None else late.lag or 0.0)
        if self._world.faults.of_camera("blackout", name):
            frame = replace(frame, image=np.zeros_like(frame.image), depth=np.zeros_like(frame.depth))
        self._last[name] = replace(frame, image=darkened(frame.image, self._world.faults.brightness))
        return self._last[name]

    def _sensed(self, spec: CameraSpec, lag: float) -> Frame:
        """Return a frame as the camera's sensor gives it, `lag` later than it would [s]."""
        noise = spec.noise
        frame = self._drawn(spec, *self._shown(lag + (0.0 if noise is None else noise.latency)))
        if noise is None:
            return frame
        self._taken[spec.name] += 1
        seed = [self._world.spec.seed, crc32(spec.name.encode()), self._taken[spec.name]]
        cosine = np.einsum("ijk,ijk->ij", frame.normals, _inward(spec))
        depth = noise.on_depth(frame.depth, cosine, float(spec.info().matrix[0, 0]), seed)
        return replace(
            frame, depth=depth, image=noise.on_image(frame.image, seed), pose=noise.on_pose(frame.pose, seed)
        )

    def view(self, camera: str | CameraSpec) -> Frame:
        """Show what is there now by a camera, or one that isn't among them, without its sensor's faults; see `look`."""
        return self._drawn(self._spec(camera) if isinstance(camera, str) else camera, *self._shown(0.0))

    def pose(self, name: str) -> Pose:
        """Return the optical frame of a camera in world, as it is now; see `look`."""
        return self._pose(self._spec(name), self._shown(0.0)[1])

    def _spec(self, name: str) -> CameraSpec:
        if name not in self._specs:
            raise UnknownNameError("camera", name, self._specs)
        return self._specs[name]

    def _shown(self, latency: float) -> tuple[float, Array]:
        """Return the last time kept at least `latency` ago [s], or the first one kept, and where bodies were then."""
        now, ago = self._world.steps, int(np.ceil(latency / self._dt - 1e-6))
        old = max((kept for kept in self._past if kept[0] <= now - ago), default=next(iter(self._past), None))
        then, packed = (now, self._pack()) if not ago or old is None else old
        rows = np.frombuffer(packed, np.float32).reshape(-1, 7)[self._places]
        return then * self._dt, np.roll(rows, 3, axis=1).astype(float)

    def _pose(self, spec: CameraSpec, rows: Array) -> Pose:
        pose = spec.info().pose
        if spec.link is None:
            return pose
        carrier = rows[self._rows[spec.link]]
        return Pose(carrier[:3], carrier[3:]) @ pose

    def _drawn(self, spec: CameraSpec, time: float, rows: Array) -> Frame:
        if spec not in self._renderers:  # made when it is first asked for, since meshes take their time to read
            self._renderers[spec] = make_renderer(spec, self.targets)
        renderer = self._renderers[spec]
        return replace(renderer.draw(self._pose(spec, rows), Places.of(rows[: len(self.targets)])), time=time)


def make_renderer(spec: CameraSpec, targets: Sequence[Target]) -> Renderer:
    """Return the renderer that a camera asks for; `auto` takes SAPIEN's where Vulkan works."""
    visual = spec.shapes == "visual"
    if spec.renderer == "sapien" or (spec.renderer == "auto" and vulkan_works()):
        from grip_sim.cameras.sapien_renderer import SapienRenderer  # it needs a driver to be imported with sense

        return SapienRenderer(spec.info(), spec.far, targets, visual)
    return RasterRenderer(spec.info(), spec.far, targets, visual)


@lru_cache(maxsize=8)  # of a camera that is the same in another world
def _inward(spec: CameraSpec) -> Array:
    """Return the direction from what each pixel sees to the camera, in the optical frame."""
    rays = spec.info().rays()
    return -rays / np.linalg.norm(rays, axis=2, keepdims=True)


RATE = 25
"""Frames a second of simulated time."""


class Film:
    """Is filled while the world goes on from `start` [s]; frames are without a sensor's faults, and change nothing.

    Raises:
        UnknownNameError: there is no such camera.
        GripError: the video (MPEG-4) or the last picture can't be written.
    """

    def __init__(self, cameras: Rig, camera: str | CameraSpec, start: float, video: Path | None, picture: Path | None):
        self._cameras, self._camera, self._picture = cameras, camera, picture
        self._start, self._taken = start, 0
        if picture is not None and not (cv2.haveImageWriter(str(picture)) and picture.parent.is_dir()):
            raise GripError(f"{picture}: a picture can't be written there; its name must end in .png or .jpg")
        height, width = cameras.view(camera).depth.shape
        self._writer: cv2.VideoWriter | None = None
        if video is not None:
            self._writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"mp4v"), RATE, (width, height))
            if not self._writer.isOpened():
                raise GripError(f"{video}: a video can't be written there; its name must end in .mp4")
        self.stepped(start)

    def stepped(self, time: float) -> None:
        """Take the frames that are due at a time of the world [s]."""
        while self._writer is not None and time >= self._start + self._taken / RATE - 1e-9:
            self._writer.write(self._frame())
            self._taken += 1

    def close(self) -> None:
        """End the film and take the last picture, unless that was done. Raises GripError where it can't be written."""
        if self._writer is not None:
            self._writer.release()
            self._writer = None
        picture, self._picture = self._picture, None
        if picture is not None and not cv2.imwrite(str(picture), self._frame()):
            raise GripError(f"{picture}: a picture can't be written there")

    def _frame(self) -> np.ndarray:
        return np.ascontiguousarray(self._cameras.view(self._camera).image[:, :, ::-1])
