"""Drawings of values as PNG, with numpy and zlib alone: images, depth, and clouds seen from above."""

from __future__ import annotations

import struct
import zlib
from base64 import b64encode

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]
LARGEST = 320
"""Longest side of a drawing [px]."""
DARK = 24
"""Background of clouds, of 255."""


def png(pixels: Pixels) -> bytes:
    """Return pixels of shape (height, width, 3) as a PNG file (ISO/IEC 15948, filter 0)."""
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + width * 3), dtype=np.uint8)
    rows[:, 1:] = pixels.reshape(height, -1)
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        _chunk(name, data)
        for name, data in ((b"IHDR", head), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b""))
    )


def address(pixels: Pixels) -> str:
    """Return pixels as a `data:` address for a page."""
    return "data:image/png;base64," + b64encode(png(pixels)).decode()


def fitted(pixels: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return an image so that its longer side has at most `LARGEST` pixels, by leaving rows and columns out."""
    step = max(1, -(-max(pixels.shape[:2]) // LARGEST))
    return pixels[::step, ::step]


def drawn_image(pixels: Pixels) -> Pixels:
    """Return a colour image, small enough."""
    return np.ascontiguousarray(fitted(pixels), dtype=np.uint8)


def drawn_depth(depth: NDArray[np.float32]) -> Pixels:
    """Return depth as grey: near is light, nothing seen is dark blue."""
    small = np.asarray(fitted(depth), dtype=float)
    seen = np.isfinite(small) & (small > 0)
    grey = _shade(small, seen)
    picture = np.repeat(grey[..., None], 3, axis=2)
    picture[~seen] = (16, 16, 48)
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


def _shade(values: NDArray[np.float64], seen: NDArray[np.bool_]) -> Pixels:
    if not seen.any():
        return np.zeros(values.shape, dtype=np.uint8)
    low, high = float(values[seen].min()), float(values[seen].max())
    near = 1 - (np.clip(np.nan_to_num(values), low, high) - low) / max(high - low, 1e-9)
    return (40 + 215 * near).astype(np.uint8)


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
