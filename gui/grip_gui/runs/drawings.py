"""Pictures, depth and clouds as small PNG files, without a library for pictures."""

from __future__ import annotations

import struct
import zlib
from base64 import b64encode

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]
LARGEST = 320  # longest side of a drawing [px]
DARK = 24  # background of clouds, of 255


def png(pixels: Pixels) -> bytes:
    """Return pixels of shape (height, width, 3) as a PNG file."""
    rows = np.insert(pixels.reshape(len(pixels), -1), 0, 0, axis=1)  # each begins with its filter: none
    head = struct.pack(">2I5B", pixels.shape[1], len(pixels), 8, 2, 0, 0, 0)
    parts = (b"IHDR" + head, b"IDAT" + zlib.compress(rows.tobytes(), 1), b"IEND")
    framed = (struct.pack(">I", len(part) - 4) + part + struct.pack(">I", zlib.crc32(part)) for part in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(framed)


def address(pixels: Pixels) -> str:
    """Return pixels as a `data:` address for a page."""
    return "data:image/png;base64," + b64encode(png(pixels)).decode()


def fitted(pixels: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return an image so that its longer side has at most `LARGEST` pixels, by leaving rows and columns out."""
    step = max(1, -(-max(pixels.shape[:2]) // LARGEST))
    return pixels[::step, ::step]


def drawn_depth(depth: NDArray[np.float32]) -> Pixels:
    """Return depth as grey: near is light, nothing seen is dark blue."""
    small = np.asarray(fitted(depth), dtype=float)
    seen = np.isfinite(small) & (small > 0)
    picture = np.full((*small.shape, 3), (16, 16, 48), dtype=np.uint8)
    if seen.any():
        low, high = small[seen].min(), small[seen].max()
        picture[seen] = (255 - 215 * (small[seen] - low) / max(high - low, 1e-9)).astype(np.uint8)[:, None]
    return picture


def drawn_cloud(points: NDArray[np.float32], colors: Pixels | None = None) -> Pixels:
    """Return a cloud seen from above, x to the right and y upwards; the highest point of a pixel is seen.

    Args:
        points: shape (n, 3) [m].
        colors: shape (n, 3), or None to colour by height.
    """
    finite = np.isfinite(points).all(axis=1)
    xyz, side = points[finite].astype(float), LARGEST // 2
    picture = np.full((side, side, 3), DARK, dtype=np.uint8)
    if not len(xyz):
        return picture
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    scale = (side - 1) / max(float((high - low)[:2].max()), 1e-6)
    column = ((xyz[:, 0] - low[0]) * scale).astype(int)
    row = side - 1 - ((xyz[:, 1] - low[1]) * scale).astype(int)
    if colors is not None:
        shade = colors[finite]
    else:
        height = (xyz[:, 2] - low[2]) / max(float(high[2] - low[2]), 1e-6)
        shade = np.stack([60 + 195 * height, 120 + 100 * (1 - np.abs(2 * height - 1)), 255 - 195 * height], axis=1)
    order = np.argsort(xyz[:, 2], kind="stable")  # the last write of a pixel stays: the highest point
    picture[row[order], column[order]] = shade[order].astype(np.uint8)
    return picture
