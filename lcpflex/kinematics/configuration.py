"""Configurations q moved by velocities u, and compared. In the plane both have one layout, and qdot = u."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Model

__all__ = ["advance", "difference"]


@kernel
def advance(model: Model, q: FloatArray, u: FloatArray, h: float, out: FloatArray) -> None:
    """out = q + h u: the configuration after moving with u for h [s]; ``out`` may be ``q`` itself."""
    for i in range(len(q)):
        out[i] = q[i] + h * u[i]


@kernel
def difference(model: Model, a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """out = b - a: what moves a to b when taken as a velocity for 1 s; ``out`` may be one of them."""
    for i in range(len(a)):
        out[i] = b[i] - a[i]
