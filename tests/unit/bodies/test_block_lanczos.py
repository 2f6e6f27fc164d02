"""Lowest modes by blocks: those of the full eigenproblem, however many have one frequency; failures are told."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.sparse import block_diag, csr_array, diags_array

import lcpflex as lf
from lcpflex.bodies.fem.factors import SuperLuFactor
from lcpflex.bodies.reduction import block_lanczos as module, eigenmodes
from lcpflex.bodies.reduction.block_lanczos import block_lanczos, check_modes
from lcpflex.errors import ModelError
from tests import solids

SPREAD = np.linspace(1.0, 100.0, 2000) ** 2


def diagonal(omega2: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Modes of single masses on springs."""
    mass, stiffness = diags_array(np.ones(len(omega2))).tocsc(), diags_array(omega2).tocsc()
    found = block_lanczos(mass, lambda loads: loads / omega2[:, None], count)
    check_modes(stiffness, mass, *found)
    return found


@pytest.mark.parametrize(
    ("omega2", "count"),
    [
        (SPREAD, 30),
        (1e-20 * SPREAD, 5),
        (1e20 * SPREAD, 5),
        (np.r_[1e-6, SPREAD], 10),
        (np.r_[np.full(3, 1.5), SPREAD], 10),
        (np.r_[np.full(30, 1.5), SPREAD], 40),  # more than the columns of a block
        (np.r_[np.full(20, 30.0), SPREAD], 150),
        (np.full(300, 2.0), 10),
        (SPREAD[:60], 58),  # nearly all of them
    ],
)
def test_frequencies_of_a_known_spectrum(omega2, count):
    found, shapes = diagonal(omega2, count)
    assert found == pytest.approx(np.sort(omega2)[:count], rel=1e-9)
    assert shapes.T @ shapes == pytest.approx(np.eye(count), abs=1e-10)
    assert abs(omega2[:, None] * shapes - shapes * found).max() <= 1e-5 * abs(omega2[:, None] * shapes).max()


def test_more_modes_of_one_frequency_than_the_widest_block(monkeypatch):
    with pytest.raises(ModelError, match="60 lowest modes were not found, more than 48 of them have one frequency"):
        diagonal(np.r_[np.full(55, 1.5), SPREAD], 60)


def test_a_solution_that_is_none():
    mass, stiffness = diags_array(np.ones(2000)).tocsc(), diags_array(SPREAD).tocsc()
    found = block_lanczos(mass, lambda loads: loads / (1.001 * SPREAD[:, None]), 5)
    with pytest.raises(ModelError, match="lowest modes are left with errors of"):
        check_modes(stiffness, mass, *found)


def test_a_long_basis_is_restarted(monkeypatch):
    monkeypatch.setattr(module, "SPARE", 2)
    found, _ = diagonal(SPREAD, 20)
    assert found == pytest.approx(SPREAD[:20], rel=1e-12)
    monkeypatch.setattr(module, "RESTARTS", 1)
    with pytest.raises(ModelError, match="20 lowest modes were not found in 1 restarts"):
        diagonal(SPREAD, 20)


@cache
def bar() -> dict[str, Any]:
    """Square: bending in both directions has one frequency."""
    return solids.block((0.2, 0.02, 0.02), (20, 3, 3), "hex1")


@cache
def cube() -> dict[str, Any]:
    return solids.block((0.1, 0.1, 0.1), (7, 7, 7), "hex1")


@pytest.mark.parametrize("made", [bar, cube])
@pytest.mark.parametrize("clamped", [None, "end"])
def test_modes_of_solids_are_those_of_single_vectors(monkeypatch, made, clamped):
    end = np.flatnonzero(made()["coordinates"][:, 0] == 0.0)
    solid = lf.SpatialMatrices(**made(), node_sets={"end": end.tolist()})
    monkeypatch.setattr(eigenmodes, "DENSE_LIMIT", 100)
    single = solid.reduce(modes=24, clamped=clamped)
    monkeypatch.setattr(SuperLuFactor, "in_blocks", True)
    blocks = solid.reduce(modes=24, clamped=clamped)
    assert blocks.frequencies() == pytest.approx(single.frequencies(), rel=1e-9)
    again = solid.reduce(modes=24, clamped=clamped)
    assert (again.frequencies() == blocks.frequencies()).all()
    ratios = single.frequencies()[1:] / single.frequencies()[:-1]
    assert (ratios < 1.0 + 1e-9).any()  # some are equal


def test_a_mechanism_is_one(monkeypatch):
    """Two blocks that share an edge turn about it."""
    part = solids.block((0.2, 0.1, 0.1), (2, 1, 2), "hex1")
    other = part["coordinates"] + [0.2, 0.1, 0.0]
    n = len(part["coordinates"])
    number = np.arange(2 * n)
    for i in range(n):
        same = np.flatnonzero(np.abs(part["coordinates"] - other[i]).max(axis=1) < 1e-9)
        if len(same):
            number[n + i] = same[0]
    used, number = np.unique(number, return_inverse=True)
    rows = (3 * number[:, None] + np.arange(3)).ravel()
    join = csr_array((np.ones(len(rows)), (rows, np.arange(len(rows)))))
    mass, stiffness = (join @ block_diag([part[name]] * 2) @ join.T for name in ("mass", "stiffness"))
    solid = lf.SpatialMatrices(mass, stiffness, np.concatenate([part["coordinates"], other])[used])
    monkeypatch.setattr(eigenmodes, "DENSE_LIMIT", 10)
    for in_blocks in (False, True):
        monkeypatch.setattr(SuperLuFactor, "in_blocks", in_blocks)
        with pytest.raises(ModelError, match="more zero modes than the 6 rigid motions"):
            solid.reduce(modes=6)


def test_modes_with_a_region_that_follows_statically(monkeypatch):
    from lcpflex.bodies.fem import meshes

    plate = lf.Continuum(meshes.rectangle(0.2, 0.1, 40, 20, order=1), 7850.0, 2.1e11, 0.3)
    mesh = plate.finite_elements()
    massless = np.zeros(len(mesh.dofs), dtype=bool)
    massless[: len(massless) // 20] = True
    monkeypatch.setattr(eigenmodes, "DENSE_LIMIT", 100)
    free = eigenmodes.FreeMesh.of(mesh, massless)
    single, _ = free.modes(20)
    monkeypatch.setattr(SuperLuFactor, "in_blocks", True)
    blocks, shapes = free.modes(20)
    assert blocks == pytest.approx(single, rel=1e-9)
    left = mesh.stiffness @ shapes - (free.mass @ shapes) * blocks
    assert abs(left).max() <= 1e-6 * abs(mesh.stiffness @ shapes).max()
