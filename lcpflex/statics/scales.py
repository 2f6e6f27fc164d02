"""How large coordinates, forces and stiffnesses are, in metres and newtons, whatever they belong to.

Coordinate i moves some material point of its body by up to s_i metres a unit: 1 for the place of a body, the distance
of its farthest point for its angle, in space from each axis of its own, the largest entry of its shape for a mode. A
displacement dq is then up to
s_i |dq_i| metres, and a generalised force f is of the size of f_i / s_i newtons: numbers that can be compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.dynamics.applied_forces import spring_stretch
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.coordinates import ANGULAR
from lcpflex.model.layout import SPACE, dimension, place_offsets
from lcpflex.statics.balance import Balance, Configuration

__all__ = ["Scales", "acting", "acting_on", "scales_of", "softest"]

# of the extent, and of the mean displacement in a mode: least arm of a turn about a body's own axis and of a mode in
# space, lest for a thin rod, which moves no point of its axis when it twists, rounding seem a force
SLENDER = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Scales:
    """Of a compiled scene with nb bodies."""

    arm: FloatArray  # (ndof,) s [m] by unit of the coordinate
    extent: FloatArray  # (nb,) distance of the farthest material point from the frame of each body [m]
    size: float  # of the largest body, and of the distances between them [m]

    def moved(self, dq: FloatArray) -> float:
        """Largest displacement by dq (ndof,) [m]."""
        return float(np.abs(self.arm * dq).max(initial=0.0))

    def off(self, at: Configuration) -> float:
        """How far joints and drives are off at most, of the size, or in rad."""
        return float(np.abs(at.phi / np.where(at.turns, 1.0, self.size)).max(initial=0.0))

    def force(self, f: FloatArray) -> float:
        """Largest force of f (ndof,) [N]."""
        return float(np.abs(f / self.arm).max(initial=0.0))


def scales_of(model: Any, q: FloatArray, size: float) -> Scales:
    """Of a model, with what is known of the ``size`` of its largest body [m]."""
    bodies, points, numbers = model.bodies, model.points, dimension(model.bodies)
    turns = numbers.rigid - numbers.components  # angles of a body
    radius = np.sqrt(_inertia(bodies) / bodies.mass[:, None])
    extent, arms = radius.max(axis=1), radius.copy()
    arm, least = np.ones(int(bodies.dof[-1])), SLENDER if turns > 1 else 0.0
    for b in range(len(bodies.mass)):
        own = np.flatnonzero(points.body == b)
        places = points.place[own]
        extent[b] = max(extent[b], _lengths(places).max(initial=0.0))
        for k in range(turns if turns > 1 else 0):
            arms[b, k] = max(arms[b, k], _lengths(np.delete(places, k, axis=1)).max(initial=0.0))
        modes = slice(int(bodies.dof[b]) + numbers.rigid, int(bodies.dof[b + 1]))
        shapes = np.zeros(modes.stop - modes.start)
        for p in own.tolist():
            shapes = np.maximum(shapes, _lengths(points.phi[points.start[p] : points.start[p + 1]]))
        usual = 1.0 / np.sqrt(bodies.mass[b])
        arm[modes] = np.maximum(np.where(shapes > 0.0, shapes, usual), least * usual)
    extent = np.where(extent > 0.0, extent, size)
    arms = np.maximum(arms, SLENDER * extent[:, None]) if turns > 1 else extent[:, None]
    arm[bodies.dof[:-1, None] + np.arange(numbers.components, numbers.rigid)] = arms
    places = q[place_offsets(bodies)[:-1, None] + np.arange(numbers.components)]
    across = float(np.ptp(places, axis=0).max(initial=0.0))
    return Scales(arm, extent, max(size, across, float(extent.max(initial=0.0))))


def _inertia(bodies: Any) -> FloatArray:
    """(nb, 1) of the angle of each body about its frame, in space (nb, 3) about its axes [kg m^2]."""
    if dimension(bodies) is SPACE:
        squares = np.einsum("bii->bi", bodies.second)
        return np.asarray(squares.sum(axis=1, keepdims=True) - squares)
    return np.asarray(bodies.inertia[:, None])


def _lengths(vectors: FloatArray) -> FloatArray:
    """(k,) of vectors (k, 2) or (k, 3)."""
    return np.asarray(np.hypot.reduce(vectors, axis=-1))


def acting(balance: Balance, scales: Scales, at: Configuration, p: FloatArray) -> float:
    """The largest force that acts on a body, cancelled or not, with the multipliers p [N].

    Residuals are relative to it, so that two springs against each other rest as exactly as their forces are known.
    """
    return float(acting_on(balance, scales, at, p).max(initial=0.0))


def acting_on(balance: Balance, scales: Scales, at: Configuration, p: FloatArray) -> FloatArray:
    """(nb,) the largest force that acts on each body, cancelled or not, with the multipliers p [N].

    Weights, springs and applied forces, elastic forces, and those of joints and contacts.
    """
    model: Any = balance.model
    loads, bodies, numbers = model.loads, model.bodies, dimension(model.bodies)
    on = bodies.mass * float(_lengths(loads.gravity))
    own = np.abs(balance.work.free.driving / scales.arm)
    for b in range(len(bodies.mass)):
        first, last = int(bodies.dof[b]) + numbers.rigid, int(bodies.dof[b + 1])
        modes = slice(first - numbers.rigid * (b + 1), last - numbers.rigid * (b + 1))
        amplitudes = at.q[int(place_offsets(bodies)[b]) + numbers.places :][: last - first]
        stiff = np.abs(bodies.stiffness[modes] * amplitudes / scales.arm[first:last])
        own[first:last] = np.maximum(own[first:last], stiff)
    if len(p):
        own = np.maximum(own, np.abs(at.rows / scales.arm * p[:, None]).max(axis=0))
    on = np.maximum(on, np.maximum.reduceat(own, bodies.dof[:-1]))
    for k, tension in enumerate(_springs(model, scales, at.q)):
        for b in model.points.body[loads.spring_point[k]]:
            if b >= 0:
                on[b] = max(on[b], float(tension))
    return np.asarray(on)


def softest(model: Any, scales: Scales) -> float:
    """Least stiffness of a spring or mode [N/m]; 0 where there is none."""
    bodies = model.bodies
    modal = np.ones(len(scales.arm), bool)
    modal[bodies.dof[:-1, None] + np.arange(dimension(bodies).rigid)] = False
    own = np.concatenate([bodies.stiffness / scales.arm[modal] ** 2, _spring_stiffness(model, scales)])
    return float(own[own > 0.0].min(initial=np.inf)) if (own > 0.0).any() else 0.0


def _spring_stiffness(model: Any, scales: Scales) -> FloatArray:
    """Of each spring [N/m], of torsion springs by the square of the extent of the largest body they turn."""
    k = np.array(model.loads.spring_value[:, 0], dtype=float)
    for s in np.flatnonzero(ANGULAR[model.loads.spring_kind]):
        k[s] /= _lever(model, scales, int(s)) ** 2
    return k


def _lever(model: Any, scales: Scales, spring: int) -> float:
    """Extent of the largest body that a torsion spring turns [m]."""
    held = [scales.extent[b] for b in model.points.body[model.loads.spring_point[spring]] if b >= 0]
    return float(max(held, default=scales.size))


def _springs(model: Any, scales: Scales, q: FloatArray) -> FloatArray:
    """Tension of each spring [N], of torsion springs by the extent of the largest body they turn."""
    loads = model.loads
    tension = np.zeros(len(loads.spring_kind))
    for k, kind in enumerate(loads.spring_kind):
        tension[k] = loads.spring_value[k, 0] * spring_stretch(model, q, k)
        if ANGULAR[kind]:
            tension[k] /= _lever(model, scales, k)
    return np.abs(tension)
