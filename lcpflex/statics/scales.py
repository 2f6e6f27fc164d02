"""How large coordinates, forces and stiffnesses are, in metres and newtons, whatever they belong to.

Coordinate i moves some material point of its body by up to s_i metres a unit: 1 for the place of a body, the distance
of its farthest point for its angle, the largest entry of its shape for a mode. A displacement dq is then up to
s_i |dq_i| metres, and a generalised force f is of the size of f_i / s_i newtons: numbers that can be compared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.relative import apart, coordinate_value
from lcpflex.model.arrays import Model
from lcpflex.model.coordinates import ANGULAR
from lcpflex.model.planar import N_RIGID
from lcpflex.statics.balance import Balance, Configuration

__all__ = ["Scales", "acting", "acting_on", "scales_of", "softest"]


@dataclass(frozen=True, slots=True, eq=False)
class Scales:
    """Of a compiled scene with nb bodies."""

    arm: FloatArray  # (ndof,) s [m] by unit of the coordinate
    extent: FloatArray  # (nb,) distance of the farthest material point from the frame of each body [m]
    size: float  # of the largest body, and of the distances between them [m]

    def moved(self, dq: FloatArray) -> float:
        """Largest displacement by dq (ndof,) [m]."""
        return float(np.abs(self.arm * dq).max(initial=0.0))

    def force(self, f: FloatArray) -> float:
        """Largest force of f (ndof,) [N]."""
        return float(np.abs(f / self.arm).max(initial=0.0))


def scales_of(model: Model, q: FloatArray, size: float) -> Scales:
    """Of a model, with what is known of the ``size`` of its largest body [m]."""
    bodies, points = model.bodies, model.points
    count = len(bodies.mass)
    extent = np.sqrt(bodies.inertia / bodies.mass)
    arm = np.ones(int(bodies.dof[-1]))
    shapes = [np.zeros(int(n) - N_RIGID) for n in np.diff(bodies.dof)]
    for p, b in enumerate(points.body):
        if b >= 0:
            extent[b] = max(extent[b], float(np.hypot(*points.place[p])))
            part = points.phi[points.start[p] : points.start[p + 1]]
            shapes[b] = np.maximum(shapes[b], np.hypot(part[:, 0], part[:, 1]))
    extent = np.where(extent > 0.0, extent, size)
    for b in range(count):
        first = int(bodies.dof[b])
        arm[first + 2] = extent[b]
        known = shapes[b] > 0.0
        arm[first + N_RIGID : int(bodies.dof[b + 1])] = np.where(known, shapes[b], 1.0 / np.sqrt(bodies.mass[b]))
    places = q[bodies.dof[:-1, None] + np.arange(2)]
    across = float(np.ptp(places, axis=0).max(initial=0.0))
    return Scales(arm, extent, max(size, across, float(extent.max(initial=0.0))))


def acting(balance: Balance, scales: Scales, at: Configuration, p: FloatArray) -> float:
    """The largest force that acts on a body, cancelled or not, with the multipliers p [N].

    Residuals are relative to it, so that two springs against each other rest as exactly as their forces are known.
    """
    return float(acting_on(balance, scales, at, p).max(initial=0.0))


def acting_on(balance: Balance, scales: Scales, at: Configuration, p: FloatArray) -> FloatArray:
    """(nb,) the largest force that acts on each body, cancelled or not, with the multipliers p [N].

    Weights, springs and applied forces, elastic forces, and those of joints and contacts.
    """
    model = balance.model
    loads, bodies = model.loads, model.bodies
    on = bodies.mass * float(np.hypot(*loads.gravity))
    own = np.abs(balance.work.free.driving / scales.arm)
    for b in range(len(bodies.mass)):
        first, last = int(bodies.dof[b]) + N_RIGID, int(bodies.dof[b + 1])
        modes = slice(first - N_RIGID * (b + 1), last - N_RIGID * (b + 1))
        stiff = np.abs(bodies.stiffness[modes] * at.q[first:last] / scales.arm[first:last])
        own[first:last] = np.maximum(own[first:last], stiff)
    if len(p):
        own = np.maximum(own, np.abs(at.rows / scales.arm * p[:, None]).max(axis=0))
    on = np.maximum(on, np.maximum.reduceat(own, bodies.dof[:-1]))
    for k, tension in enumerate(_springs(model, scales, at.q)):
        for b in model.points.body[loads.spring_point[k]]:
            if b >= 0:
                on[b] = max(on[b], float(tension))
    return np.asarray(on)


def softest(model: Model, scales: Scales) -> float:
    """Least stiffness of a spring or mode [N/m]; 0 where there is none."""
    bodies = model.bodies
    modal = np.ones(len(scales.arm), bool)
    modal[bodies.dof[:-1, None] + np.arange(N_RIGID)] = False
    own = np.concatenate([bodies.stiffness / scales.arm[modal] ** 2, _spring_stiffness(model, scales)])
    return float(own[own > 0.0].min(initial=np.inf)) if (own > 0.0).any() else 0.0


def _spring_stiffness(model: Model, scales: Scales) -> FloatArray:
    """Of each spring [N/m], of torsion springs by the square of the extent of the largest body they turn."""
    k = np.array(model.loads.spring_value[:, 0], dtype=float)
    for s in np.flatnonzero(ANGULAR[model.loads.spring_kind]):
        k[s] /= _lever(model, scales, int(s)) ** 2
    return k


def _lever(model: Model, scales: Scales, spring: int) -> float:
    """Extent of the largest body that a torsion spring turns [m]."""
    held = [scales.extent[b] for b in model.points.body[model.loads.spring_point[spring]] if b >= 0]
    return float(max(held, default=scales.size))


def _springs(model: Model, scales: Scales, q: FloatArray) -> FloatArray:
    """Tension of each spring [N], of torsion springs by the extent of the largest body they turn."""
    loads = model.loads
    tension = np.zeros(len(loads.spring_kind))
    for k, kind in enumerate(loads.spring_kind):
        i, j = loads.spring_point[k]
        place = apart(model.bodies, model.points, q, i, j)
        x, y = loads.spring_axis[k]
        tension[k] = loads.spring_value[k, 0] * (coordinate_value(kind, place, x, y) - loads.spring_value[k, 2])
        if ANGULAR[kind]:
            tension[k] /= _lever(model, scales, k)
    return np.abs(tension)
