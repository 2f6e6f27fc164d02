"""Whether a place of rest is stable, and whether there are others next to it.

What holds to first order are joints, pressed contacts and sticking ones: C dq = 0. In the directions Z that are left,
with the tangent stiffness K (constraint forces of fixed size turn with the bodies and count in it),

    stable where Z^T K Z is positive definite;  where a contact slips, the forces of B stand for C on the left.

A direction in which nothing changes is neutral. Places of rest next to this one, to which friction lets it be moved:
dq of normals and joints alone, J dq = 0 and W_N dq = 0, whose change of forces K dq sticking contacts can take up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import orth

from lcpflex.dynamics.mass_matrix import null_space
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.statics.balance import Configuration
from lcpflex.statics.refinement import LARGE, coordinate_units, sets_of
from lcpflex.statics.scales import Scales
from lcpflex.statics.shared_forces import SharedForces

__all__ = ["Stability", "stability_of"]

NEUTRAL = 1e-7  # stiffness, in units of the stiffness of each coordinate, that is none


@dataclass(frozen=True, slots=True, eq=False)
class Stability:
    """Of a place of rest."""

    stable: bool  # no direction in which forces push away
    unstable: FloatArray  # (k, ndof) directions of these
    neutral: FloatArray  # (k, ndof) directions in which nothing changes
    neighbours: int  # dimension of the places of rest next to it by friction
    family: FloatArray  # (k, ndof) directions in which such places may lie, and the neutral ones


def stability_of(
    at: Configuration, K: FloatArray, forces: SharedForces, scales: Scales, on: FloatArray, dof: IntArray
) -> Stability:
    """Of a configuration with its tangent stiffness K and its forces, the largest on each body being ``on`` (nb,) [N].

    Light bodies are measured by their own forces, lest all that holds or overturns them seem nothing beside heavy ones.
    """
    r, n = at.n_joint, at.n_contacts
    normal = forces.p[r : r + n][at.tangent]
    ratio = np.where(normal > 0.0, forces.p[r + n :] / np.where(normal > 0.0, normal, 1.0), 0.0)
    sets = sets_of(at, forces.pressed, ratio, forces.sticks)
    smooth = sets_of(at, forces.pressed, ratio, np.zeros(len(at.tangent), bool))
    c = coordinate_units(K, scales, np.repeat(np.where(on > 0.0, on, 1.0), np.diff(dof)))
    scaled = K * np.outer(c, c)
    Z = _free(sets.hold, c)
    Y = Z if np.array_equal(sets.push, sets.hold) else _free(sets.push, c)
    if Y.shape != Z.shape:
        Y = Z
    within = Y.T @ (scaled @ Z)
    reduced = within if Y is Z else np.asarray(np.linalg.solve(Y.T @ Z, within), dtype=np.float64)
    wide = _free(smooth.hold, c)
    if len(reduced) > LARGE and _resists(reduced, 1.0 if Y is Z else _likeness(sets.hold * c, sets.push * c)):
        neighbours = wide.shape[1] - Z.shape[1]
        none = np.zeros((0, len(c)))
        return Stability(True, none, none, neighbours, wide.T * c if neighbours else none)
    values, vectors = np.linalg.eig(reduced)
    ways = (Z @ vectors.real).T * c
    sizes = np.linalg.svd(Y.T @ (scaled @ wide), compute_uv=False)
    held = int((sizes > NEUTRAL).sum())
    neutral = np.abs(values.real) <= NEUTRAL
    neighbours = max(wide.shape[1] - held - int(neutral.sum()), 0)
    return Stability(
        stable=not (values.real < -NEUTRAL).any(),
        unstable=ways[values.real < -NEUTRAL],
        neutral=ways[neutral],
        neighbours=neighbours,
        family=np.vstack([ways[neutral], wide.T * c]) if neighbours else ways[neutral],
    )


def _resists(reduced: FloatArray, likeness: float) -> bool:
    """Whether it is sure, without its eigenvalues, that ``reduced`` (f, f) resists in all directions.

    Where its symmetric part is above NEUTRAL / sigma, sigma the least singular value of Y^T Z (``likeness``), so are
    the real parts of its eigenvalues, and singular values of Y^T K Z = Y^T Z reduced are above NEUTRAL: all f
    directions are held. A factor of Cholesky's tells it in a hundredth of the time.
    """
    if not likeness > 0.0:
        return False
    try:
        np.linalg.cholesky(0.5 * (reduced + reduced.T) - NEUTRAL / likeness * np.eye(len(reduced)))
    except np.linalg.LinAlgError:
        return False
    return True


def _likeness(hold: FloatArray, push: FloatArray) -> float:
    """Least cosine between what rows (k, ndof) span and what as many others do: as between what they let pass."""
    across = orth(push.T).T @ orth(hold.T)
    return float(np.linalg.svd(across, compute_uv=False).min(initial=1.0))


def _free(rows: FloatArray, c: FloatArray) -> FloatArray:
    """(ndof, f) directions that rows let pass, in the units c."""
    scaled = rows * c
    sizes = np.linalg.norm(scaled, axis=1, keepdims=True)
    return null_space(scaled / np.where(sizes > 0.0, sizes, 1.0))
