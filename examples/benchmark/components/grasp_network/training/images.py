"""Draw what the network learns from: things that fall onto the bench in GRIP's simulator, seen as its camera sees them.

    python training/images.py --out images.npz [--count 200] [--seed 1000000]

None of the benchmark's objects is among them: boxes, cylinders and balls of many sizes, and those of the library that
the benchmark doesn't have, larger and smaller. Seeds are beyond any campaign's.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from labels import labels  # noqa: E402
from network import SIDE, heights, square  # noqa: E402

from grip_bt.base.values import Pose  # noqa: E402
from grip_sim.specs import WorldSpec  # noqa: E402
from grip_sim.world import World  # noqa: E402
from grip_sim.worlds import arrange  # noqa: E402
from grip_sim.worlds.model import WorldFile  # noqa: E402

BENCH = HERE.parents[2] / "worlds" / "bench.yaml"
OTHERS = "apple bowl cup hammer mug pen plate screwdriver spanner spoon t_shape tape tube tumbler tuna_tin".split()
PLAIN = (
    {"shape": "box", "radius": [0.008, 0.036], "height": [0.012, 0.18]},
    {"shape": "cylinder", "radius": [0.008, 0.036], "height": [0.012, 0.18]},
    {"shape": "sphere", "radius": [0.012, 0.036]},
)
SETTLED, FALLS = 1.2, 4  # how long a thing falls and rolls [s], and how often in a world
ARM = [-1.4, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]  # where it hides nothing [rad]


def worlds(count: int, first: int) -> Iterator[WorldSpec]:
    """Yield the bench with one thing each, and a second camera that has no noise."""
    bench = yaml.safe_load(BENCH.read_text())
    choice = [*PLAIN, *PLAIN, *({"model": name, "scale": [0.6, 1.1]} for name in OTHERS)]
    for seed in range(first, first + count):
        bench["objects"]["thing"]["of"] = [choice[seed % len(choice)]]
        spec = arrange(WorldFile.model_validate(bench), seed, BENCH.parent, "panda")
        (camera,) = spec.cameras
        yield replace(spec, cameras=(camera, replace(camera, name="clean", noise=None)))


def examples(spec: WorldSpec) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield how high things rise in the square that the network sees, and its labels, for each of some falls."""
    world, name, info = World(spec), spec.objects[0].name, spec.cameras[0].info()
    world.robot.place(dict(zip(world.robot.description.group("arm"), ARM, strict=True)))
    rng = np.random.default_rng(spec.seed)
    for fall in range(FALLS):
        if fall:
            spot = [*rng.uniform([0.44, -0.09], [0.56, 0.09]), 0.13]
            world.move_object(name, Pose(spot, rng.normal(size=4)))
        for _ in range(round(SETTLED / spec.dt)):
            world.step()
        noisy, _ = heights(world.look("overhead").depth)
        clean, table = heights(world.look("clean").depth)
        corner = square(noisy)
        if corner is None:
            continue
        column, row = info.project(world.object_pose(name).position[None])[0] - 0.5
        part = tuple(slice(at, at + SIDE) for at in corner)
        told = labels(clean[part], table / info.matrix[0, 0], (row - corner[0], column - corner[1]))
        yield noisy[part].astype(np.float16), told[::2, ::2].astype(np.float16)


def main() -> int:
    """Draw, label and store them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--count", type=int, default=200, help="worlds, of which each shows several falls")
    parser.add_argument("--seed", type=int, default=1_000_000)
    args = parser.parse_args()
    seen, told = [], []
    for spec in worlds(args.count, args.seed):
        for height, label in examples(spec):
            seen.append(height)
            told.append(label)
        if len(seen) % 20 < FALLS:
            print(len(seen), flush=True)
    np.savez_compressed(args.out, seen=np.array(seen), told=np.array(told))
    print(f"{len(seen)} images, in {sum((t[..., 0] > 0.3).any() for t in told)} of them a good grasp: {args.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
