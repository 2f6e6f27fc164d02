"""Half of a hinged strip, y > 0, strikes a rigid sphere: matrices of the library's elements, all else is done here.

The plane y = 0 does not move along y. The hinge is a stiff spring on the mean of its end face; modes are ARPACK's of
the strip that hangs there; nodes of the patch stay out of the sphere, z >= -(x^2 + y^2) / 2R, by forces that move the
modes and, at once, what else gives way: the residual compliance D. 0 <= force, gap + D force >= 0, in each step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, eigsh, splu

import lcpflex as lf

__all__ = ["HalfStrip", "half_strip"]

Floats = npt.NDArray[np.float64]
LENGTH, HALF, THICKNESS = 0.7, 0.014, 0.005
HELD = 1e13  # stiffness of the hinge [N/m]
SHIFT = (2.0 * np.pi * 300.0) ** 2  # [1/s^2], which makes the swing regular; of D it changes SHIFT / omega^2


@dataclass(frozen=True)
class HalfStrip:
    """Modes with masses of one at the nodes of the patch."""

    square: Floats  # (n,) of frequencies [rad^2/s^2], the swing first
    shapes: Floats  # (k, n) deflections of the nodes
    residual: Floats  # (k, k) D [m/N]
    distance: Floats  # (k,) from the middle of the patch [m]

    def struck(self, radius: float, speed: float, step: float, duration: float) -> tuple[Floats, Floats]:
        """Times [s] and forces [N] of the whole strip."""
        omega = np.sqrt(np.maximum(self.square, 0.0))
        omega[0] = 0.0
        gap, turned = self.distance**2 / (2.0 * radius), omega * step
        cos, sin, over = np.cos(turned), np.sin(turned), step * np.sinc(turned / np.pi)
        q, u = np.zeros((2, len(omega)))
        u[0] = -speed / self.shapes[:, 0].mean()
        closed = np.zeros(len(gap), dtype=bool)
        forces = np.zeros(round(duration / step))
        for k in range(len(forces)):
            q, u = cos * q + over * u, cos * u - omega * sin * q
            force, closed = self._pushed(gap + self.shapes @ q, closed)
            u += step * (force @ self.shapes)
            forces[k] = 2.0 * force.sum()
        return step * (1.0 + np.arange(len(forces))), forces

    def _pushed(self, gap: Floats, closed: npt.NDArray[np.bool_]) -> tuple[Floats, npt.NDArray[np.bool_]]:
        """The forces, and which nodes touch, from those that did."""
        for _ in range(50):
            force = np.zeros(len(gap))
            force[closed] = np.linalg.solve(self.residual[np.ix_(closed, closed)], -gap[closed])
            right = np.where(closed, force > 0.0, gap + self.residual @ force < -1e-15)
            if (right == closed).all():
                return force, closed
            closed = right
        raise AssertionError("no nodes that touch were found")


def half_strip(reach: float, size: float, modes: int) -> HalfStrip:
    """The strip of ``solid_strip`` in elements of its own."""
    middle = np.array([reach - 0.5 * LENGTH, -0.5 * HALF, -0.5 * THICKNESS])
    solid = lf.Solid.box(
        (LENGTH, HALF, THICKNESS), size, near={"patch": (tuple(middle), 1.5e-4, 5.5e-4, 2.0)},
        density=2700.0, youngs_modulus=6.9e10, poissons_ratio=0.33,
    ).finite_elements()  # fmt: skip
    places = solid.places
    free = np.setdiff1d(np.arange(3 * len(places)), 3 * np.flatnonzero(places[:, 1] < -0.5 * HALF + 1e-9) + 1)
    number = np.full(3 * len(places), -1)
    number[free] = np.arange(len(free))
    spring = _means(places)[:, free]
    stiffness = (solid.stiffness[free][:, free] + HELD * (spring.T @ spring)).tocsc()
    mass = solid.mass[free][:, free].tocsc()
    factor = splu(
        (stiffness + SHIFT * mass).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )  # fmt: skip
    inverse: Any = LinearOperator(stiffness.shape, matvec=factor.solve)
    square, shapes = eigsh(stiffness, modes, M=mass, sigma=-SHIFT, OPinv=inverse)
    distance = np.linalg.norm(places - middle, axis=1)
    patch = np.flatnonzero((distance < 5.5e-4) & (places[:, 2] < middle[2] + 1e-9))
    rows = number[3 * patch + 2]
    loads = np.zeros((len(free), len(rows)))
    loads[rows, np.arange(len(rows))] = 1.0
    at = shapes[rows]
    residual = factor.solve(loads)[rows] - (at / (square + SHIFT)) @ at.T
    return HalfStrip(square, at, 0.5 * (residual + residual.T), distance[patch])


def _means(places: Floats) -> sp.csr_matrix:
    """(2, 3 N) of x and z over the face at the hinge: trapezia between its lines."""
    (face,) = np.nonzero(places[:, 0] < -0.5 * LENGTH + 1e-9)
    share = np.ones(len(face))
    for axis in (1, 2):
        lines, of = np.unique(np.round(places[face, axis], 10), return_inverse=True)
        share *= (np.convolve(np.diff(lines), [0.5, 0.5]) / np.ptp(lines))[of]
    rows = np.zeros((2, 3 * len(places)))
    rows[0, 3 * face], rows[1, 3 * face + 2] = share, share
    return sp.csr_matrix(rows)
