"""Momenta of spatial bodies over a step of the massless-boundary scheme, kept to rounding.

Inertial forces that depend on the velocity are explicit there, of second order: a body that spins would lose its
angular momentum with the square of the step. In world axes it changes by forces alone,

    L+ = L + h/2 (T + T+),   T: torques of all but inertial forces about the origin of the world

and so does the linear one. What u_h + h/2 a+, with the inertial forces h of a+, leaves of that is put into u_h as an
impulse on the frame: M d = [target - M u_h - h/2 h, 0], third order in h. Impulses that fulfil the joints are forces,
too. Source of the balance: Simo & Wong 1991.
"""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.mechanics import multiply, solve_vector
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.inertia_solve import turn_in, turn_out
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.model.spatial import SpatialModel

__all__ = ["carry_momenta", "note_momenta"]


@kernel
def about_origin(model: SpatialModel, q: FloatArray, b: int, x: FloatArray, work: SpatialWork) -> tuple[Vector, Vector]:
    """A force or momentum x of the frame of body b, torque in its axes, as one about the origin, in world axes."""
    d, i = model.bodies.dof[b], model.bodies.place[b]
    force = x[d], x[d + 1], x[d + 2]
    own = turn_out(work.rows.arrow.axes, b, x[d + 3], x[d + 4], x[d + 5])
    orbit = cross((q[i], q[i + 1], q[i + 2]), force)
    return force, (own[0] + orbit[0], own[1] + orbit[1], own[2] + orbit[2])


@kernel
def carry_momenta(model: Any, scheme: Any, h: float, work: SpatialWork) -> None:
    """Change u_h, ``work.free.u``, such that u_h + h/2 a+ has the momenta that all but inertial forces leave."""
    q, found, shift, spin = work.free.middle, work.scratch.velocity, work.rows.arrow.shift, work.rows.arrow.spin
    multiply(model, q, work.free.u, work, found)
    multiply(model, q, scheme.joined, work, shift)
    for b in range(len(model.bodies.mass)):
        d, i = model.bodies.dof[b], model.bodies.place[b]
        pushed, turned = about_origin(model, q, b, shift, work)
        before, wrench = scheme.momentum[b], scheme.wrench[b]
        p = (
            before[0] + 0.5 * h * wrench[0] + pushed[0],
            before[1] + 0.5 * h * wrench[1] + pushed[1],
            before[2] + 0.5 * h * wrench[2] + pushed[2],
        )
        orbit = cross((q[i], q[i + 1], q[i + 2]), p)
        own = turn_in(
            work.rows.arrow.axes, b,
            before[3] + 0.5 * h * wrench[3] + turned[0] - orbit[0],
            before[4] + 0.5 * h * wrench[4] + turned[1] - orbit[1],
            before[5] + 0.5 * h * wrench[5] + turned[2] - orbit[2],
        )  # fmt: skip
        for c in range(3):
            shift[d + c] = p[c] - found[d + c] - 0.5 * h * spin[d + c]
            shift[d + 3 + c] = own[c] - found[d + 3 + c] - 0.5 * h * spin[d + 3 + c]
        for k in range(d + 6, model.bodies.dof[b + 1]):
            shift[k] = 0.0
    solve_vector(model, work, shift)
    for k in range(len(shift)):
        work.free.u[k] += shift[k]


@kernel
def note_momenta(model: Any, scheme: Any, work: SpatialWork) -> None:
    """Keep the momenta at the end of the step, and what changes them, for the next one."""
    found, q = work.scratch.velocity, scheme.q
    multiply(model, q, scheme.acceleration, work, found)
    for k in range(len(found)):
        found[k] -= work.rows.arrow.spin[k]
    keep(model, q, found, work, scheme.wrench)
    multiply(model, q, scheme.u, work, found)
    keep(model, q, found, work, scheme.momentum)


@kernel
def keep(model: SpatialModel, q: FloatArray, x: FloatArray, work: SpatialWork, out: FloatArray) -> None:
    """out (nb, 6) = x of all frames about the origin of the world."""
    for b in range(len(model.bodies.mass)):
        force, torque = about_origin(model, q, b, x, work)
        for c in range(3):
            out[b, c] = force[c]
            out[b, 3 + c] = torque[c]
