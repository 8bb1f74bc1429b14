"""Train the network on what `images.py` drew, and store its weights beside the server.

    python -m venv training_env && training_env/bin/pip install jax opencv-python-headless
    training_env/bin/python training/train.py images.npz [--epochs 30] [--seed 0]

Running the network needs none of this: `network.py` is plain numpy. As in GG-CNN, all four maps are learnt at once;
angle and width count only where a grasp is good. Pictures are mirrored at random. The last tenth of them is kept back.
"""

from __future__ import annotations

import argparse
import sys
import time
from functools import partial
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from network import HEIGHTS, LAYERS, WEIGHTS, WIDTHS, forward  # noqa: E402

SIZES = {"first": (5, 1, 16), "second": (3, 16, 16), "third": (3, 16, 32), "fourth": (3, 32, 32), "fifth": (3, 32, 32)}
SIZES |= {"sixth": (3, 48, 16), "head": (1, 16, 4)}
BATCH, RATE = 16, 2e-3


def begun(seed: int) -> dict[str, jnp.ndarray]:
    """Return random weights (He et al. 2015)."""
    rng, made = np.random.default_rng(seed), {}
    for name, (size, inner, outer) in SIZES.items():
        spread = np.sqrt(2 / (size * size * inner))
        made[name] = jnp.asarray(rng.normal(0, spread, (size, size, inner, outer)), jnp.float32)
        made[name + "_bias"] = jnp.zeros(outer, jnp.float32)
    made["head_bias"] = made["head_bias"].at[0].set(-2.0)
    return made


def maps(weights: dict[str, jnp.ndarray], seen: jnp.ndarray) -> jnp.ndarray:
    """Return the four maps of pictures, shape (n, h, w); quality before the sigmoid. The same as `network.forward`."""

    def layer(value: jnp.ndarray, name: str, stride: int = 1, dilation: int = 1) -> jnp.ndarray:
        pad = dilation * (weights[name].shape[0] // 2)
        out = jax.lax.conv_general_dilated(
            value,
            weights[name],
            (stride, stride),
            [(pad, pad)] * 2,
            rhs_dilation=(dilation, dilation),
            dimension_numbers=("NHWC", "HWIO", "NHWC"),
        )
        return out[:, : -(-value.shape[1] // stride), : -(-value.shape[2] // stride)] + weights[name + "_bias"]

    value, kept = seen[..., None], None
    for name, stride, dilation in LAYERS:
        value = jax.nn.relu(layer(value, name, stride, dilation))
        kept = value if name == "second" else kept
    value = jnp.concatenate([value.repeat(2, axis=1).repeat(2, axis=2), kept], axis=3)
    return layer(jax.nn.relu(layer(value, "sixth")), "head")


def loss(weights: dict[str, jnp.ndarray], seen: jnp.ndarray, told: jnp.ndarray) -> jnp.ndarray:
    """Return the cross entropy of quality, and the squares of what angle and width err where a grasp is good."""
    out, quality = maps(weights, seen), told[..., 0]
    entropy = jnp.logaddexp(0.0, out[..., 0]) - quality * out[..., 0]
    errs = ((out[..., 1:] - told[..., 1:]) ** 2).sum(axis=-1)
    good = quality * (quality > 0.2)
    return ((1 + 4 * quality) * entropy).mean() + 0.5 * (good * errs).sum() / (good.sum() + 1.0)


@partial(jax.jit, donate_argnums=(0, 1))
def step(weights, moments, count, rate, seen, told):
    """Return weights and moments after a step of Adam (Kingma and Ba 2015), and the loss before it."""
    value, slope = jax.value_and_grad(loss)(weights, seen, told)
    first = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * g, moments[0], slope)
    second = jax.tree.map(lambda v, g: 0.999 * v + 0.001 * g * g, moments[1], slope)
    size = rate * jnp.sqrt(1 - 0.999**count) / (1 - 0.9**count)
    weights = jax.tree.map(lambda w, m, v: w - size * m / (jnp.sqrt(v) + 1e-8), weights, first, second)
    return weights, (first, second), value


def mirrored(seen: np.ndarray, told: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return a batch, turned over or transposed at random; angles follow."""
    if rng.random() < 0.5:  # transposed: the angle becomes a quarter turn less itself
        seen, told = seen.transpose(0, 2, 1), told.transpose(0, 2, 1, 3) * [1, -1, 1, 1]
    for axis in (1, 2):
        if rng.random() < 0.5:  # the grid of labels begins at pixel 0, which stays
            seen = np.roll(np.flip(seen, axis), 1, axis)
            told = np.roll(np.flip(told, axis), 1, axis) * [1, 1, -1, 1]
    return np.ascontiguousarray(seen, np.float32), np.ascontiguousarray(told, np.float32)


def best_peak(out: np.ndarray, told: np.ndarray) -> float:
    """Return how good the labels say the best predicted cell is, were it closed at the predicted angle."""
    i, j = np.unravel_index(int(out[..., 0].argmax()), out.shape[:2])
    near = told[max(0, i - 1) : i + 2, max(0, j - 1) : j + 2].reshape(-1, 4)
    alike = near[:, 1:3] @ out[i, j, 1:3] / (np.linalg.norm(out[i, j, 1:3]) + 1e-9)
    return float((near[:, 0] * (alike > np.cos(np.radians(40)))).max())


def main() -> int:
    """Train and store."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("images", type=Path)
    parser.add_argument("--epochs", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=WEIGHTS)
    args = parser.parse_args()
    stored = np.load(args.images)
    seen = HEIGHTS * np.clip(stored["seen"].astype(np.float32), 0, 0.3)
    told = stored["told"].astype(np.float32)
    told[..., 3] /= WIDTHS
    kept = len(seen) - len(seen) // 10
    rng, weights = np.random.default_rng(args.seed), begun(args.seed)
    moments, count = (jax.tree.map(jnp.zeros_like, weights),) * 2, 0
    moments = jax.tree.map(jnp.array, moments)
    steps = args.epochs * (kept // BATCH)
    for epoch in range(args.epochs):
        losses = []
        for rows in rng.permutation(kept)[: kept // BATCH * BATCH].reshape(-1, BATCH):
            count += 1
            rate = RATE * 0.5 * (1 + np.cos(np.pi * count / steps))
            weights, moments, value = step(weights, moments, count, rate, *mirrored(seen[rows], told[rows], rng))
            losses.append(float(value))
        plain = {name: np.asarray(value) for name, value in weights.items()}
        score = np.mean([best_peak(forward(plain, s), t) for s, t in zip(seen[kept:], told[kept:], strict=True)])
        most = np.mean([t[..., 0].max() for t in told[kept:]])
        print(f"{epoch + 1:3} loss {np.mean(losses):.4f}, kept back: best peak {score:.3f} of {most:.3f}", end="")
        print(f", {time.process_time():.0f} s of CPU", flush=True)
        np.savez_compressed(args.out, **{name: value.astype(np.float16) for name, value in plain.items()})
    return 0


if __name__ == "__main__":
    sys.exit(main())
