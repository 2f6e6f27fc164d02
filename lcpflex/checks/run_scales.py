"""What is large or small in a finished run: sizes, speeds, travel, and how light bodies are where they are pushed."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.dynamics.mass_matrix import held_inverse, mass_matrix
from lcpflex.dynamics.start import violation
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.layout import PLANE, dimension, place_offsets
from lcpflex.model.spatial import N_PLACE
from lcpflex.results.result import Result

__all__ = ["RunScales", "masses_and_joints"]


class RunScales:
    """What is large or small in a run."""

    def __init__(self, result: Result, compiled: CompiledScene) -> None:
        model = compiled.model
        _, rigid, components = dimension(model.bodies)
        dof = model.bodies.dof[:-1, None]
        self.size = compiled.size
        self.duration = float(result.times[-1])
        spins = np.linalg.norm(result.u[:, dof + np.arange(components, rigid)], axis=2)
        self.spin = float(spins.max())
        speeds = np.linalg.norm(result.u[:, dof + np.arange(components)], axis=2) + 0.5 * self.size * spins
        self.speed = float(speeds.max())
        places = result.q[:, place_offsets(model.bodies)[:-1, None] + np.arange(components)]
        travel = np.linalg.norm(np.ptp(places, axis=0), axis=1)
        self.travel = float((travel + 0.5 * self.size * _turned(result, model.bodies)).max())
        self.weight = float(model.bodies.mass.sum() * np.linalg.norm(model.loads.gravity))
        self._compiled = compiled
        self._rigid = (dof + np.arange(rigid)).ravel()

    @cached_property
    def _mechanics(self) -> tuple[FloatArray, FloatArray]:
        return masses_and_joints(self._compiled, self._compiled.q)

    @cached_property
    def _inverse(self) -> FloatArray:
        return held_inverse(*self._mechanics)

    @cached_property
    def _stiff(self) -> FloatArray:
        M, J = self._mechanics
        return held_inverse(M[np.ix_(self._rigid, self._rigid)], J[:, self._rigid])

    def mobility(self, rows: FloatArray) -> float:
        """Largest change of speed by a unit impulse along ``rows`` (k, ndof) [1/kg] or [1/(kg m^2)], joints held."""
        return max(float(np.linalg.eigvalsh(rows @ self._inverse @ rows.T)[-1]), 0.0)

    def drift(self, rows: FloatArray) -> float:
        """The same of bodies as if they were rigid: what lasts."""
        rows = rows[:, self._rigid]
        return max(float(np.linalg.eigvalsh(rows @ self._stiff @ rows.T)[-1]), 0.0)


def _turned(result: Result, bodies: Any) -> FloatArray:
    """By how much each body has turned (nb,) [rad]; in space the range of the integral of its angular velocity.

    Rotations from one stored instant to the next are added as vectors: about a fixed axis that is the angle.
    """
    if dimension(bodies) is PLANE:
        return np.asarray(np.ptp(result.q[:, bodies.dof[:-1] + 2], axis=0))
    p = result.q[:, bodies.place[:-1, None] + np.arange(3, N_PLACE)]
    w, v = p[..., :1], p[..., 1:]
    scalar = w[1:] * w[:-1] + (v[1:] * v[:-1]).sum(axis=-1, keepdims=True)
    vector = w[:-1] * v[1:] - w[1:] * v[:-1] - np.cross(v[1:], v[:-1])
    vector *= np.where(scalar < 0.0, -1.0, 1.0)  # the shorter way round
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(length, np.abs(scalar))
    steps = np.divide(angle * vector, length, out=np.zeros_like(vector), where=length > 0.0)
    ways = np.concatenate([np.zeros((1, *steps.shape[1:])), np.cumsum(steps, axis=0)])
    return np.asarray(np.linalg.norm(np.ptp(ways, axis=0), axis=-1))


def masses_and_joints(compiled: CompiledScene, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mass matrix (ndof, ndof) and rows of the joints (nj, ndof) at q, drives as at t = 0."""
    still, external = np.zeros_like(compiled.u), np.zeros((compiled.n_external, 3))
    return mass_matrix(compiled.model, q), violation(compiled.model, q, still, external).jacobian
