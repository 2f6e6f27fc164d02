"""Depth that time stepping leaves in a contact for good, against what its springs give for it.

A pair closes within a step, up to h |gdot| / 2 deep, and Moreau-Jean keeps it there. Where the bodies are held by
springs, elastic modes or contacts by a force law, these are then strained by so much more or less. Looked at is the
last instant, and contacts that have been closed for a while: with the stiffness K of all that and W^T dq = d,

    K dq = J^T mu + W dlambda,   J dq = 0
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from lcpflex.checks.grown import has_grown
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import near, normal_row
from lcpflex.dynamics.applied_forces import spring_forces
from lcpflex.dynamics.mass_matrix import mass_matrix, null_space
from lcpflex.dynamics.shortening import add_tangent
from lcpflex.dynamics.start import violation
from lcpflex.force_laws.elastic.kernels import elastic_stiffness
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.configuration import advance
from lcpflex.model.arrays import Model
from lcpflex.model.layout import dimension, is_spatial
from lcpflex.model.planar import N_RIGID
from lcpflex.results.result import Result

__all__ = ["kept_depths", "stiffness_of"]

OFF = 0.005  # of a contact force, from where on a run warns
GOOD = 0.001  # of it, which the step should be chosen for
LASTING = 0.05  # of the stored instants, the last ones, in which the contact is closed
DIFFERENCE = 1e-6  # of the largest coordinate, at least of 1


def kept_depths(result: Result) -> tuple[str, ...]:
    """A warning for each contact whose force is off for the depth at which it is kept."""
    compiled = result.compiled
    if compiled is None or len(result.times) == 0 or has_grown(result):
        return ()
    lasting = result.force[-max(2, int(LASTING * len(result.times))) :, :, 0].min(axis=0) > 0.0
    deep = lasting & (result.gap[-1] < 0.0) & ~np.isin(result.contact_names, result.compliant)
    if not deep.any():
        return ()
    off = _forces_off(compiled, result.q[-1].copy(), np.flatnonzero(deep))
    found = []
    for law, force in off.items():
        pressed = float(result.force[-1, law, 0])
        share = abs(force) / pressed
        if share > OFF:
            found.append(
                f"contact {result.contact_names[law]!r} closed within a step and is kept {-result.gap[-1, law]:.4g} m "
                f"deep: by the springs that act on it, its force of {pressed:.4g} N is off by about "
                f"{100.0 * share:.2g} %; a step {share / GOOD:.2g} times shorter brings that to {100.0 * GOOD:g} %"
            )
    return tuple(found)


def _forces_off(compiled: CompiledScene, q: FloatArray, deep: IntArray) -> dict[int, float]:
    """By how much the forces of the contacts ``deep`` [N] would change if all came up to the gap 0, by contact."""
    model = pack(compiled.model)
    if not (len(model.loads.spring_kind) or len(model.bodies.stiffness) or any(compiled.laws)):
        return {}  # nothing is strained by it, and the matrices below are the square of thousands of bodies
    table, found = near(model, q, 0.0)
    still = np.zeros(int(model.bodies.dof[-1]))
    W = np.array([normal_row(model, q, table, k) for k in range(found)]).reshape(found, len(still))
    laws, gaps = table.law[:found], table.gap[:found]
    K = stiffness_of(model, q)
    for k in range(found):
        law = compiled.laws[laws[k]] if laws[k] < len(compiled.laws) else None  # those of a rule are rigid
        if law is not None and gaps[k] < 0.0:
            row = law.row()
            K += elastic_stiffness(np.array(row.kinds), np.array(row.parameters), -gaps[k]) * np.outer(W[k], W[k])
    held = [k for k in range(found) if laws[k] in deep and gaps[k] < 0.0]
    if not held:
        return {}
    J = violation(compiled.model, q, still, np.zeros((compiled.n_external, 3))).jacobian
    scale = 1.0 / np.sqrt(np.diag(mass_matrix(compiled.model, q)))  # of coordinates: metres, radians, modal ones
    Z = null_space(J * scale)
    rows = (W[held] * scale) @ Z
    stiffness = Z.T @ (scale[:, None] * K * scale) @ Z
    sizes, vectors = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    soft = sizes <= 1e-9 * sizes.max(initial=0.0)  # bodies that move so feel no spring
    if not sizes.size or sizes.max() <= 0.0:
        return {}
    along = rows @ vectors
    free = along[:, soft]
    # contacts that come up by such motions strain nothing; the others do against each other
    firm = null_space(free.T) if soft.any() else np.eye(len(held))
    G = firm.T @ (along[:, ~soft] / sizes[~soft]) @ along[:, ~soft].T @ firm
    change = firm @ (np.linalg.pinv(G, rcond=1e-10, hermitian=True) @ (firm.T @ -gaps[held]))
    return {int(law): float(change[laws[held] == law].sum()) for law in np.unique(laws[held])}


def stiffness_of(model: Model, q: FloatArray) -> FloatArray:
    """Of springs, by differences, and of elastic modes (ndof, ndof); the model is a packed one."""
    dof, rigid = model.bodies.dof, dimension(model.bodies).rigid
    n = int(dof[-1])
    K, still, away = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    if len(model.loads.spring_kind):
        step = DIFFERENCE * max(1.0, float(np.abs(q).max()))
        for j in range(n):
            for side in (1.0, -1.0):
                moved, force = _moved(model, q, j, side * step), np.zeros(n)
                spring_forces(model, moved, still, force, away)
                K[:, j] -= side * force / (2.0 * step)
    elastic = np.concatenate([np.arange(a + rigid, b) for a, b in pairwise(dof)])
    K[elastic, elastic] += model.bodies.stiffness
    if is_spatial(model):
        return K  # no stiffening
    for b in np.flatnonzero(np.diff(model.bodies.shortening_start)).tolist():
        own = slice(dof[b] + N_RIGID, dof[b + 1])
        axial = np.zeros((dof[b + 1] - dof[b] - N_RIGID,) * 2)
        add_tangent(model.bodies, b, q[own], 1.0, True, axial)
        K[own, own] += axial
    return K


def _moved(model: Model, q: FloatArray, j: int, way: float) -> FloatArray:
    """q moved along velocity j alone."""
    moved = q.copy()
    if is_spatial(model):
        along = np.zeros(int(model.bodies.dof[-1]))
        along[j] = way
        advance(model, q, along, 1.0, moved)
    else:
        moved[j] += way
    return moved
