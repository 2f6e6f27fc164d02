"""Beams of space under axial load that their bending does not feel, against the load at which they buckle.

N(x) is that of :mod:`lcpflex.results.spatial.section_forces` at some instants without collisions, less what the
stiffness of the beam counts with (:class:`lcpflex.Stiffening`). As in :mod:`lcpflex.checks.buckling`, with the modes
that the beam has, in both planes:

    max of  - integral of N (slope_y^2 + slope_z^2) dx  /  (elastic energy of the scene, doubled)

over all small motions that joints, and contacts that press along their normals, allow.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics.alarm import Alarm
from lcpflex.bodies.spatial.beam_elements import BeamMesh, section_fields
from lcpflex.checks.kept_depth import stiffness_of
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import near, normal_row
from lcpflex.dynamics.mass_matrix import mass_matrix, null_space, slowest_vibrations
from lcpflex.dynamics.start import violation
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.model.recovery import SpatialLineShapes
from lcpflex.model.spatial import N_RIGID
from lcpflex.results.result import Result
from lcpflex.results.spatial.section_forces import spatial_section_forces

__all__ = ["spatial_axial_loads"]

TOLD = 0.1  # of the load at which a beam buckles, from where on it is told
BUCKLED = (
    0.85  # of it: eight free modes make a cantilever 13 % stiffer than it is, and deflections are 6 times too small
)
LOOSE = 1e-4  # of the square of its lowest frequency: what is held less turns as a whole
DO = (
    "take a stiffer beam, or a smaller load, or stiffening=Stiffening(axial_force=...) if it is constant: no beam of "
    "space feels another axial force"
)
NEAR = 1e-6  # of the size of the scene: gaps of contacts that press


def spatial_axial_loads(
    result: Result,
    compiled: CompiledScene,
    b: int,
    instants: IntArray,
    calm: bool,
    lasts: float,
    step: float,
) -> tuple[str, bool]:
    """What is to be said of beam b, in words, and whether it buckles: bears BUCKLED of that load for ``lasts``.

    calm: whether ``instants`` are without collisions; else the one of median compression is taken. lasts: in its
    slowest vibrations. step: mean one of the run [s], 0 of a place of rest.
    """
    line = compiled.recovery[b]
    assert isinstance(line, SpatialLineShapes)
    x = np.linspace(-0.5 * line.length, 0.5 * line.length, len(line.shapes))
    N = _uncounted(result, compiled, b, line, instants, x, step)
    least = N.min(axis=1)
    when = int(least.argmin() if calm else np.argsort(least)[len(least) // 2])
    if not least[when] < 0.0:
        return "", False
    k = int(instants[when])
    share = _share(result, compiled, b, line, k, N[when])
    if not share >= TOLD:
        return "", False
    held = float((-least * share >= -least[when] * BUCKLED).mean() * (result.times[-1] - result.times[0]))
    buckles = share >= BUCKLED and held >= lasts * float(slowest_vibrations(compiled.model.bodies)[b])
    feels = "it has no such state, and its bending" if buckles else "its bending"
    station = x[int(N[when].argmin())]
    name = f"beam {compiled.layout.bodies[b]!r}"
    clause = (
        f"{name}: compression of {-least[when]:.4g} N at x = {station:.4g} m, "
        f"t = {result.times[k]:.6g} s, {100.0 * share:.3g} % of the load at which it buckles, held as it is: "
        f"{feels} does not feel that"
    )
    return Alarm(clause, "axial load", name, float(result.times[k]), float(-least[when]), DO), buckles


def _uncounted(
    result: Result,
    compiled: CompiledScene,
    b: int,
    line: SpatialLineShapes,
    instants: IntArray,
    x: FloatArray,
    step: float,
) -> FloatArray:
    """N (instants, nodes) that the stiffness of beam b does not count with [N]: neither spin nor the force given."""
    N = np.array(spatial_section_forces(result, compiled, b, x, step, instants).N)
    if not len(line.spin):
        return N
    d = int(compiled.model.bodies.dof[b])
    across = np.sum(result.u[instants, d + 4 : d + 6] ** 2, axis=1)
    N -= across[:, None] * line.spin
    other = N - line.given
    return np.asarray(np.where(np.abs(other) < np.abs(N), other, N))


def _share(result: Result, compiled: CompiledScene, b: int, line: SpatialLineShapes, k: int, N: FloatArray) -> float:
    """The quotient at stored instant k under N at the nodes of the beam [N]."""
    model, q = compiled.model, result.q[k].copy()
    packed: Any = pack(model)
    still = np.zeros(result.u.shape[1])
    J = violation(model, q, still, np.zeros((compiled.n_external, 3))).jacobian
    table, found = near(packed, q, NEAR * compiled.size)
    pressed = np.flatnonzero(result.force[k, :, 0] > 0.0)
    rows = [normal_row(packed, q, table, i) for i in range(found) if table.law[i] in pressed]
    Z = null_space(np.vstack([J, *(row[None] for row in rows)]))
    L = np.linalg.cholesky(Z.T @ mass_matrix(model, q) @ Z)
    into = np.linalg.solve(L, Z.T).T
    sizes, vectors = np.linalg.eigh(into.T @ stiffness_of(packed, q) @ into)
    dof = model.bodies.dof
    own = model.bodies.stiffness[dof[b] - N_RIGID * b : dof[b + 1] - N_RIGID * (b + 1)]
    firm = sizes > LOOSE * float(own.min(initial=np.inf))
    bent = into @ vectors[:, firm] / np.sqrt(sizes[firm])
    if not own.size or not bent.shape[1]:
        return 0.0
    slopes = np.zeros((2, len(N), len(still)))
    d, end = int(dof[b]), int(dof[b + 1])
    slopes[0, :, d + 4] = slopes[1, :, d + 5] = 1.0  # about y and z of the body
    slopes[:, :, d + N_RIGID : end] = _turns(line)[:, 1:].transpose(1, 0, 2)
    weight = -N * np.gradient(np.linspace(0.0, line.length, len(N)))
    weight[[0, -1]] *= 0.5
    G = sum(one.T @ (weight[:, None] * one) for one in slopes)
    return max(0.0, float(np.linalg.eigvalsh(bent.T @ G @ bent)[-1]))


def _turns(line: SpatialLineShapes) -> FloatArray:
    """(nodes, 3, n) rotation of the section at each node, of each mode."""
    mesh = BeamMesh(len(line.shapes) - 1, line.length, (line.shear[0], line.shear[1]))
    element = np.minimum(np.arange(len(line.shapes)), mesh.elements - 1)
    along = np.arange(len(line.shapes), dtype=np.float64) - element
    turn = section_fields(mesh, along)[1]
    own = np.concatenate([line.shapes[element], line.shapes[element + 1]], axis=1)
    return np.asarray(np.einsum("gik,gkn->gin", turn, own))
