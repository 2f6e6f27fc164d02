"""Configurations q moved by velocities u, and compared. In the plane both have one layout, and qdot = u."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model

__all__ = ["advance", "difference", "magnitudes", "normalise", "rate"]


@in_space("lcpflex.kinematics.spatial.configuration")
@kernel
def advance(model: Model, q: FloatArray, u: FloatArray, h: float, out: FloatArray) -> None:
    """out = q + h u: the configuration after moving with u for h [s]; ``out`` may be ``q`` itself."""
    for i in range(len(q)):
        out[i] = q[i] + h * u[i]


@in_space("lcpflex.kinematics.spatial.configuration")
@kernel
def difference(model: Model, a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """out = b - a: what moves a to b when taken as a velocity for 1 s; ``out`` may be one of them."""
    for i in range(len(a)):
        out[i] = b[i] - a[i]


@in_space("lcpflex.kinematics.spatial.configuration")
@kernel
def rate(model: Model, q: FloatArray, u: FloatArray, out: FloatArray) -> None:
    """out = qdot, the rates (nq,) of the numbers in q where the velocity is u: in the plane, u."""
    for i in range(len(u)):
        out[i] = u[i]


@in_space("lcpflex.kinematics.spatial.configuration")
@kernel
def normalise(model: Model, q: FloatArray) -> None:
    """Take out of q what an integrator of its numbers has left beside the configurations: in the plane, nothing."""


@in_space("lcpflex.kinematics.spatial.magnitudes")
@kernel
def magnitudes(model: Model, q: FloatArray, out: FloatArray) -> None:
    """out (nu,): what changes of q, as :func:`difference` tells them, are small against: in the plane, |q|."""
    for i in range(len(q)):
        out[i] = abs(q[i])
