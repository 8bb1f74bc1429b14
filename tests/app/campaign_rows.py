"""Rows of a campaign's results, and Wilson's interval worked out by hand."""

from __future__ import annotations

import math


def row(variant: str, seed: int, success: bool, **more) -> dict:
    told = {"status": "success" if success else "failure", "outcome": "success" if success else "failure", "code": None}
    known = {
        "trial": f"{variant}@{seed}",
        "message": "",
        "duration": 1.0,
        "wall": 2.0,
        "run": None,
        "truth": None,
        "counts": {},
        "measures": {},
    }
    return {"variant": variant, "seed": seed, "success": success, **told, **known, "unclear": {}, **more}


def by_hand(good: int, n: int, z: float = 1.959963984540054) -> tuple[float, float]:
    p = good / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return max(0.0, middle - half), min(1.0, middle + half)
