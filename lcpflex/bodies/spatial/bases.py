"""Bases of spatial reductions: (omega2, shapes), M-orthonormal, of a mesh that floats or is held at some nodes."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.bodies.fem.sparse_factor import Factor
from lcpflex.bodies.reduction.bases import (
    SHARE,
    Basis,
    Flexible,
    constraint_columns,
    held_factor,
    interface_basis,
)
from lcpflex.bodies.reduction.damping import count_of_modes
from lcpflex.bodies.reduction.eigenmodes import FreeMesh, check_mass, check_memory, fixed_modes, orthonormal_frame
from lcpflex.bodies.reduction.orthonormal_basis import own_basis
from lcpflex.bodies.spatial.elastic import ElasticMesh
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["boundary_basis", "free_basis", "given_basis"]

THREE = "three that are not on one line"
GONE = 1e-9  # length of a column without its rigid motion, relative to before, below which nothing elastic is left


class HeldMesh:
    """A mesh some of whose rows are held, ready for static loads and modes; shapes are of all rows, zero there."""

    def __init__(self, mesh: ElasticMesh, held: IntArray) -> None:
        check_mass(mesh.mass)
        f = len(mesh.rank)
        self.mass, self.stiffness = mesh.mass, mesh.stiffness
        self.frame: FloatArray = np.zeros((f, 0))
        self._inner = np.setdiff1d(np.arange(f), held)
        inner = self._inner
        self._M: Any = mesh.mass[inner][:, inner].tocsc()
        self._K: Any = mesh.stiffness[inner][:, inner].tocsc()
        words = ("clamped: with its nodes held", THREE)
        self._factor: Factor = held_factor(self._M, self._K, mesh.rank[inner], words)

    def modes(self, count: int) -> Basis:
        """The lowest modes."""
        omega2, found = fixed_modes(self._M, self._K, self._factor, count)
        shapes = np.zeros((len(self.frame), count))
        shapes[self._inner] = found
        return omega2, shapes

    def flexibility(self, loads: FloatArray) -> FloatArray:
        """Static response to loads (f, k)."""
        out = np.zeros_like(loads)
        out[self._inner] = self._factor.solve(loads[self._inner])
        return out


def elastic_count(mesh: ElasticMesh, clamped: IntArray | None) -> int:
    """How many elastic modes there are."""
    return len(mesh.rank) - (6 if clamped is None else len(clamped))


def free_basis(mesh: ElasticMesh, loads: FloatArray, modes: int | None, clamped: IntArray | None) -> tuple[Basis, int]:
    """The lowest modes, and the static response of all others to loads (f, k); how many columns are modes."""
    most = elastic_count(mesh, clamped)
    n = count_of_modes(modes, most)
    check_memory("interfaces, modes", len(mesh.rank), SHARE * (loads.shape[1] + n))
    free: Flexible = (
        FreeMesh(mesh.mass, mesh.stiffness, mesh.rigid, mesh.rank) if clamped is None else HeldMesh(mesh, clamped)
    )
    if not loads.shape[1] or n == most:
        return free.modes(n), n
    return interface_basis(free, loads, n), n


def boundary_basis(mesh: ElasticMesh, boundary: IntArray, modes: int | None, clamped: IntArray | None) -> Basis:
    """Constraint modes of the boundary rows, and modes of the mesh held there (Craig and Bampton)."""
    words = ("boundary: with its nodes held", THREE)
    if clamped is None:
        columns = constraint_columns(mesh, mesh.rank, boundary, modes, words)
        frame = orthonormal_frame(mesh.mass, mesh.rigid)
        return own_basis(mesh.mass, mesh.stiffness, frame, columns, holds_rigid=True)
    moving = np.setdiff1d(boundary, clamped)
    if not len(moving):
        raise ModelError("boundary: all of its nodes are clamped, too, expected some that move")
    held = np.concatenate([moving, clamped])
    columns = constraint_columns(mesh, mesh.rank, held, modes, words, free=len(moving))
    return own_basis(mesh.mass, mesh.stiffness, np.zeros((len(mesh.rank), 0)), columns, holds_rigid=False)


def given_basis(mesh: ElasticMesh, basis: FloatArray, clamped: IntArray | None) -> Basis:
    """What is elastic in the span of columns (f, k).

    Raises
    ------
    ModelError
        For columns that move what is clamped, and where nothing elastic is in them.
    """
    check_mass(mesh.mass)
    if clamped is not None:
        frame: FloatArray = np.zeros((len(basis), 0))
        moved = float(np.abs(basis[clamped]).max(initial=0.0))
        if moved > GONE * float(np.abs(basis).max(initial=0.0)):
            raise ModelError(f"basis: it moves what is clamped (by {moved:.3g}), expected zeros at these nodes")
        basis = basis.copy()
        basis[clamped] = 0.0
    else:
        frame = orthonormal_frame(mesh.mass, mesh.rigid)
    before = np.sqrt(np.einsum("fk,fk->k", basis, mesh.mass @ basis))
    for _ in range(2):
        basis = basis - frame @ (frame.T @ (mesh.mass @ basis))
    after = np.sqrt(np.einsum("fk,fk->k", basis, mesh.mass @ basis))
    kept = after > GONE * before
    if not kept.any():
        raise ModelError("basis: nothing elastic is in it, expected columns beyond rigid motions")
    return own_basis(mesh.mass, mesh.stiffness, frame, basis[:, kept], holds_rigid=False)
