"""Random numbers as functions of a seed and a counter.

A system keeps only the counter, in its Context, so a cloned Context goes on with the same numbers and
two runs with the same seed are identical.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def splitmix64(seed: np.uint64, counter: np.uint64) -> np.uint64:
    """The random word number `counter` (from 0) of a seed: 64 bits.

    Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
    """
    z = seed + (counter + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit(cache=True)
def uniform(seed: int, counter: int) -> float:
    """Number `counter` of a seed's uniform sequence, within (0, 1)."""
    # Hashing the seed first keeps neighbouring seeds from giving shifted sequences.
    word = splitmix64(splitmix64(np.uint64(seed), np.uint64(0)), np.uint64(counter))
    return (float(word >> np.uint64(11)) + 0.5) * 2.0**-53


@njit(cache=True)
def normal_pair(seed: int, counter: int) -> tuple[float, float]:
    """Pair number `counter` of a seed's standard normal sequence (Box and Muller 1958)."""
    radius = math.sqrt(-2.0 * math.log(uniform(seed, 2 * counter)))
    angle = 2.0 * math.pi * uniform(seed, 2 * counter + 1)
    return radius * math.cos(angle), radius * math.sin(angle)


@njit(cache=True)
def fill_normal(seed: int, counter: int, out: NDArray[np.float64]) -> None:
    """Fill `out` (n,) with standard normal numbers; each `counter` gives an independent row."""
    n = len(out)
    pairs = (n + 1) // 2
    for i in range(pairs):
        a, b = normal_pair(seed, counter * pairs + i)
        out[2 * i] = a
        if 2 * i + 1 < n:
            out[2 * i + 1] = b
