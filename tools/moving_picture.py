"""Makes a moving picture for a page of the film of a run.

    grip run examples/tasks/reactive_pick.yaml --seed 3 --video run.mp4 --view 1.25,0.75,0.75,0.5,-0.05,0.18
    python tools/moving_picture.py run.mp4 docs/pictures/reactive_pick.webp [--every 9] [--width 480] [--quality 60]

It repeats itself, at 12 frames a second.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
from PIL import Image


def main() -> None:
    """Write every so many frames of a film as a WebP that repeats itself, at 12 frames a second."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("film", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--every", type=int, default=9)
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--quality", type=int, default=60)
    args = parser.parse_args()
    film, frames = cv2.VideoCapture(str(args.film)), []
    while (read := film.read())[0]:
        frames.append(read[1])
    height = round(frames[0].shape[0] * args.width / frames[0].shape[1])
    shown = [
        Image.fromarray(cv2.resize(frame, (args.width, height), interpolation=cv2.INTER_AREA)[:, :, ::-1])
        for frame in frames[:: args.every]
    ]
    shown[0].save(
        args.picture, save_all=True, append_images=shown[1:], duration=83, loop=0, quality=args.quality, method=6
    )
    print(f"{args.picture}: {len(shown)} frames, {args.picture.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
