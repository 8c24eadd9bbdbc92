#!/usr/bin/env python3
"""A plain neural network of the noisy pairs of python/notebooks/4_learn_from_noisy_pairs.ipynb, for comparison: needs NumPy alone.

    tools/plain_network.py [--seconds S] [--seed N]

The network x' = x + W₃ tanh(W₂ tanh(W₁ x + b₁) + b₂) + b₃ has 32 units in each layer and knows nothing of the bracket. Adam lowers the mean square of its
error for a minute, with a rate that falls by cosine. Printed are its errors on states that no pair has, and what its map does to |x|² and to the energy.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

H, SIGMA, UNITS = 0.5, 1e-3, 32


def velocity(x: np.ndarray) -> np.ndarray:
    """ẋ = x × ∇H of H = x²/2 + 2y²/3 + 0.4z² + 0.3xyz."""
    u, v, w = np.moveaxis(x, -1, 0)
    slope = np.stack([u + 0.3 * v * w, 4 * v / 3 + 0.3 * u * w, 0.8 * w + 0.3 * u * v], axis=-1)
    return np.cross(x, slope)


def energy(x: np.ndarray) -> np.ndarray:
    """H."""
    u, v, w = np.moveaxis(x, -1, 0)
    return u**2 / 2 + 2 * v**2 / 3 + 0.4 * w**2 + 0.3 * u * v * w


def flow(x: np.ndarray, steps: int = 64) -> np.ndarray:
    """x after the time H by Runge and Kutta's method: 64 steps leave 1e-10."""
    h = H / steps
    for _ in range(steps):
        a = velocity(x)
        b = velocity(x + h / 2 * a)
        c = velocity(x + h / 2 * b)
        x = x + h / 6 * (a + 2 * b + 2 * c + velocity(x + h * c))
    return x


def pairs() -> tuple[np.ndarray, np.ndarray]:
    """Those of the notebook, with its draws."""
    random = np.random.default_rng(44)
    starts = random.standard_normal((12, 3))
    starts *= random.uniform(0.9, 1.1, (12, 1)) / np.linalg.norm(starts, axis=1, keepdims=True)
    states = [starts]
    for _ in range(40):
        states.append(flow(states[-1]))
    orbits = np.stack(states, axis=1)
    before, after = (part.reshape(-1, 3) for part in (orbits[:, :-1], orbits[:, 1:]))
    before, after = (part + SIGMA * random.standard_normal(part.shape) for part in (before, after))
    return before, after


def network(p: list[np.ndarray], x: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """x' and what the slopes need."""
    one = np.tanh(x @ p[0] + p[1])
    two = np.tanh(one @ p[2] + p[3])
    return x + two @ p[4] + p[5], [x, one, two]


def slopes(p: list[np.ndarray], left: np.ndarray, kept: list[np.ndarray]) -> list[np.ndarray]:
    """Of the mean of |left|² by every parameter."""
    x, one, two = kept
    back = 2 * left / len(x)
    second = (back @ p[4].T) * (1 - two**2)
    first = (second @ p[2].T) * (1 - one**2)
    return [x.T @ first, first.sum(0), one.T @ second, second.sum(0), two.T @ back, back.sum(0)]


def trained(before: np.ndarray, after: np.ndarray, seed: int, seconds: float) -> tuple[list[np.ndarray], int]:
    """Parameters after so many seconds of the processor, and the steps made."""
    random = np.random.default_rng(seed)
    sizes = [(3, UNITS), (UNITS, UNITS), (UNITS, 3)]
    p = [part for n, m in sizes for part in (random.standard_normal((n, m)) / np.sqrt(n), np.zeros(m))]
    mean = [np.zeros_like(part) for part in p]
    square = [np.zeros_like(part) for part in p]
    begin, step, done = time.process_time(), 0, 0.0
    while done < 1:
        step += 1
        done = (time.process_time() - begin) / seconds
        rate = 1e-2 * (1e-4 + (1 + np.cos(np.pi * min(done, 1))) / 2)
        found, kept = network(p, before)
        for part, slope, m, v in zip(p, slopes(p, found - after, kept), mean, square, strict=True):
            m += 0.1 * (slope - m)
            v += 0.001 * (slope**2 - v)
            part -= rate * (m / (1 - 0.9**step)) / (np.sqrt(v / (1 - 0.999**step)) + 1e-8)
    return p, step


def main() -> None:
    """As the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    before, after = pairs()
    p, steps = trained(before, after, options.seed, options.seconds)
    random = np.random.default_rng(45)
    unseen = random.standard_normal((200, 3))
    unseen *= random.uniform(0.9, 1.1, (200, 1)) / np.linalg.norm(unseen, axis=1, keepdims=True)
    rms = np.sqrt(np.mean((network(p, unseen)[0] - flow(unseen)) ** 2))
    print(f"{sum(part.size for part in p)} parameters, {steps} steps of Adam, seed {options.seed}")
    print(f"one step from unseen states: {rms:.1e}")
    x = start = np.array([0.6, 0.7, 0.3])
    true, worst, square, change = start, 0.0, 0.0, 0.0
    for k in range(1, 10_001):
        x = network(p, x[None])[0][0]
        if k <= 40:
            true = flow(true)
            worst = max(worst, float(np.max(np.abs(x - true))))
        square = max(square, float(abs(x @ x - start @ start)))
        change = max(change, float(abs(energy(x) - energy(start))))
    print(f"40 steps: off by {worst:.1e}; 10 000 steps: |x|² moves by {square:.1e}, the energy by {change:.1e}")


if __name__ == "__main__":
    main()
