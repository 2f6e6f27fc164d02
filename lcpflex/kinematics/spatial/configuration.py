"""Configurations q of spatial bodies moved by velocities u, and compared: q (7 + n numbers a body), u (6 + n)."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import compose, conjugate, exponential, logarithm, unit
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialModel

__all__ = ["advance", "difference", "normalise", "rate"]


@kernel
def advance(model: SpatialModel, q: FloatArray, u: FloatArray, h: float, out: FloatArray) -> None:
    """out = q (+) h u: R + h v, p o exp(h omega) of length 1, eta + h etadot; ``out`` may be ``q`` itself."""
    dof, place = model.bodies.dof, model.bodies.place
    for b in range(len(place) - 1):
        i, d = place[b], dof[b]
        out[i] = q[i] + h * u[d]
        out[i + 1] = q[i + 1] + h * u[d + 1]
        out[i + 2] = q[i + 2] + h * u[d + 2]
        turn = exponential(h * u[d + 3], h * u[d + 4], h * u[d + 5])
        w, x, y, z = unit(compose((q[i + 3], q[i + 4], q[i + 5], q[i + 6]), turn))
        out[i + 3] = w
        out[i + 4] = x
        out[i + 5] = y
        out[i + 6] = z
        for k in range(dof[b + 1] - d - N_RIGID):
            out[i + N_PLACE + k] = q[i + N_PLACE + k] + h * u[d + N_RIGID + k]


@kernel
def difference(model: SpatialModel, a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    """The velocity (nu,) that moves a to b in 1 s when it is constant; rotations by the shortest way."""
    dof, place = model.bodies.dof, model.bodies.place
    for body in range(len(place) - 1):
        i, d = place[body], dof[body]
        for k in range(3):
            out[d + k] = b[i + k] - a[i + k]
        before = a[i + 3], a[i + 4], a[i + 5], a[i + 6]
        after = b[i + 3], b[i + 4], b[i + 5], b[i + 6]
        x, y, z = logarithm(compose(conjugate(before), after))
        out[d + 3] = x
        out[d + 4] = y
        out[d + 5] = z
        for k in range(dof[body + 1] - d - N_RIGID):
            out[d + N_RIGID + k] = b[i + N_PLACE + k] - a[i + N_PLACE + k]


@kernel
def rate(model: SpatialModel, q: FloatArray, u: FloatArray, out: FloatArray) -> None:
    """out (nq,) = qdot of the numbers in q: Rdot = v, pdot = 1/2 p o (0, omega), etadot."""
    dof, place = model.bodies.dof, model.bodies.place
    for b in range(len(place) - 1):
        i, d = place[b], dof[b]
        spin = 0.0, 0.5 * u[d + 3], 0.5 * u[d + 4], 0.5 * u[d + 5]
        w, x, y, z = compose((q[i + 3], q[i + 4], q[i + 5], q[i + 6]), spin)
        for k in range(3):
            out[i + k] = u[d + k]
        out[i + 3] = w
        out[i + 4] = x
        out[i + 5] = y
        out[i + 6] = z
        for k in range(dof[b + 1] - d - N_RIGID):
            out[i + N_PLACE + k] = u[d + N_RIGID + k]


@kernel
def normalise(model: SpatialModel, q: FloatArray) -> None:
    """Give all quaternions of q the length 1, which integrators of their numbers keep to their order alone."""
    place = model.bodies.place
    for b in range(len(place) - 1):
        i = place[b] + 3
        w, x, y, z = unit((q[i], q[i + 1], q[i + 2], q[i + 3]))
        q[i] = w
        q[i + 1] = x
        q[i + 2] = y
        q[i + 3] = z
