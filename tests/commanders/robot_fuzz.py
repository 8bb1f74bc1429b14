"""Spoils robots' files at random, loads each, and counts what comes of it. Run as a process of its own, with limits.

Usage: robot_fuzz.py KIND COUNT SEED, KIND one of urdf, srdf, xacro. Prints `valid N refused N`; anything but a typed
error or a model that can be computed with ends it with a traceback.
"""

from __future__ import annotations

import random
import resource
import sys
import tempfile
from pathlib import Path

import robot_files

from grip_bt.base.errors import GripError
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.kinematics.model import RobotModel

WORDS = ["", "nan", "inf", "-1", "0", "1e308", "base", "l6", "j1", "fixed", "revolute", "continuous", "planar", "\x00"]
PIECES = [
    "<",
    ">",
    "/",
    '"',
    "&amp;",
    "&lt",
    "<robot>",
    "</robot>",
    "<link name='x'/>",
    "<mimic joint='j1'/>",
    "é",
    "${1/0}",
]


def spoiled(text: str, rng: random.Random) -> str:
    """Return a text with one to six random faults: of its words, its lines, its elements, its characters."""
    for _ in range(rng.randint(1, 6)):
        way, at = rng.randrange(7), rng.randrange(len(text) + 1)
        if way == 0:  # one attribute says something else
            quotes = [k for k, c in enumerate(text) if c == '"']
            if len(quotes) > 2:
                k = rng.randrange(0, len(quotes) - 1)
                text = text[: quotes[k] + 1] + rng.choice(WORDS) + text[quotes[k + 1] :]
        elif way == 1:
            text = text[:at] + rng.choice(PIECES) + text[at:]
        elif way == 2:
            text = text[:at] + text[at + rng.randint(1, 60) :]
        elif way == 3:  # lines twice, or elsewhere
            lines = text.splitlines(keepends=True)
            lines.insert(rng.randrange(len(lines) + 1), rng.choice(lines) if lines else "")
            text = "".join(lines)
        elif way == 4:  # one line less
            lines = text.splitlines(keepends=True)
            del lines[rng.randrange(len(lines)) if lines else 0 :][:1]
            text = "".join(lines[: len(lines)])
        elif way == 5:  # a name exchanged for another
            one, other = rng.sample(["base", "l1", "l2", "l5", "palm", "j1", "j3", "gripper", "manipulator"], 2)
            text = text.replace(f'"{one}"', f'"{other}"', rng.randint(1, 3))
        elif text:
            at %= len(text)
            text = text[:at] + chr(rng.randrange(1, 0x250)) + text[at + 1 :]
    return text or " "


def main(kind: str, count: int, seed: int) -> None:
    """Load that many spoiled robots."""
    resource.setrlimit(resource.RLIMIT_CPU, (300, 300))
    rng, valid, refused = random.Random(seed), 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        package = robot_files.description_package(folder)
        urdf, srdf = folder / "r.urdf", folder / "r.srdf"
        urdf.write_text(robot_files.urdf())
        srdf.write_text(robot_files.SRDF)
        config = RobotConfig(urdf="r.urdf", srdf="r.srdf")
        spoilt, text = {"urdf": (urdf, robot_files.urdf()), "srdf": (srdf, robot_files.SRDF)}.get(
            kind, (package / "urdf" / "parts.xacro", robot_files.PARTS)
        )
        if kind == "xacro":
            config = RobotConfig(xacro=str(package / "urdf" / "smally.urdf.xacro"), groups={})
        for _ in range(count):
            spoilt.write_text(spoiled(text, rng), errors="surrogatepass")
            try:
                robot = load_robot(config, folder)
                model = RobotModel(robot)
                assert set(map(str, model.model.names[1:])) == {*robot.drives}
                valid += 1
            except GripError:
                refused += 1
    sys.stdout.write(f"valid {valid} refused {refused}\n")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
