"""The levels of a meshed body, and reductions of random small meshes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

import lcpflex as lf
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.reduction.component_modes import (
    craig_bampton,
    free_interface,
    residual_compliance,
    sub_regional,
    unreduced,
)
from lcpflex.bodies.solid_of_revolution import SolidOfRevolution

# Coarse linear meshes, for short runs: what is reduced has all of their stiffness, right or not.
pytestmark = pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.errors.ModelWarning")

E, RHO = 2e11, 7800.0


def plate(nx: int = 20, ny: int = 6) -> Continuum:
    return Continuum(meshes.rectangle(1.0, 0.2, nx, ny, order=1), RHO, E, 0.3)


def names(body: lf.Body) -> list[str]:
    assert body.fidelity_levels is not None
    return [level.name for level in body.fidelity_levels()]


@pytest.mark.slow
def test_levels_lead_from_rigid_to_the_full_mesh() -> None:
    model = plate()
    body = residual_compliance(model, "right", 10, damping=lf.Rayleigh(3.0, 1e-6))
    levels = body.fidelity_levels()
    powers = [f"{2**k} modes" for k in range(1, 8)]
    assert [level.name for level in levels] == ["rigid", "1 mode", *powers, "boundary nodes", "full mesh"]
    for level in levels:
        made = level.make()
        assert made.modes == level.modes
        assert made.mass == pytest.approx(body.mass, rel=1e-13)
        assert made.damping == pytest.approx(3.0 + 1e-6 * made.stiffness)
        assert names(made) == names(body)
    assert levels[-2].modes == 32 + 2 * 7  # seven nodes on the right
    boundary = levels[-2].make()
    assert boundary.stiffness[:32] == pytest.approx(free_interface(model, 32).stiffness, rel=1e-12)
    assert levels[-1].make().stiffness == pytest.approx(unreduced(model).stiffness, rel=1e-9)


def test_boundary_nodes_of_a_body_without_a_choice_are_those_of_its_named_sets() -> None:
    levels = {level.name: level for level in free_interface(plate(), 4).fidelity_levels()}
    outline = 2 * (20 + 6)
    assert levels["boundary nodes"].modes == 32 + 2 * outline
    many = Continuum(meshes.rectangle(1.0, 1.0, 40, 40, order=1), RHO, E, 0.3)  # 160 nodes on the outline, 41 on a side
    levels = {level.name: level for level in free_interface(many, 4).fidelity_levels()}
    assert levels["boundary nodes"].modes == 32 + 2 * (4 * 41 - 4 - 39)  # three sides: a fourth would be too many


def test_a_large_mesh_has_no_full_level() -> None:
    body = free_interface(plate(100, 30), 1)
    assert names(body)[-1] == "boundary nodes"
    assert "full mesh" not in names(body)


def test_levels_of_a_solid_of_revolution() -> None:
    model = SolidOfRevolution(meshes.rectangle(1.0, 0.2, 16, 4, order=1), RHO, E, 0.3)
    for level in craig_bampton(model, "left").fidelity_levels():
        made = level.make()
        assert (made.modes, made.axisymmetric) == (level.modes, True)


def test_ratios_for_each_mode_end_the_levels() -> None:
    body = free_interface(plate(), 3, damping=[0.1, 0.2, 0.3])
    assert names(body) == ["rigid", "1 mode", "2 modes", "3 modes"]
    made = body.fidelity_levels()[-1].make()
    assert np.array_equal(made.damping, body.damping)


def random_model(seed: int) -> Continuum:
    """A convex cloud of points, triangulated, with any Poisson's ratio."""
    import skfem

    rng = np.random.default_rng(seed)
    places = rng.uniform(0.0, [1.0, rng.uniform(0.3, 1.0)], (int(rng.integers(12, 30)), 2))
    cells = Delaunay(places).simplices
    corners = places[cells]
    area = np.linalg.det(corners[:, 1:] - corners[:, :1])
    cells = cells[np.abs(area) > 2e-4]  # slivers out
    used, cells = np.unique(cells, return_inverse=True)
    mesh = skfem.MeshTri1(places[used].T, cells.reshape(-1, 3).T)
    return Continuum(mesh, RHO, E, float(rng.uniform(-0.5, 0.45)))


@pytest.mark.parametrize("seed", [*range(10), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(10, 20))])
def test_random_meshes(seed: int) -> None:
    model = random_model(seed)
    rng = np.random.default_rng(seed)
    mesh = model.finite_elements()
    count = len(mesh.places)
    nodes = rng.permutation(count)[: int(rng.integers(2, count // 2))].tolist()
    modes = int(rng.integers(0, 8))
    full = unreduced(model)
    bodies = {
        "free": free_interface(model, modes),
        "boundary": craig_bampton(model, nodes, modes),
        "region": sub_regional(model, nodes, modes),
        "residual": residual_compliance(model, nodes, modes),
        "whole boundary": craig_bampton(model, list(range(count)), None),
        "all fixed": craig_bampton(model, nodes, None),
        "all of the rest": sub_regional(model, nodes, None),
        "all modes": residual_compliance(model, nodes, None),
    }
    for name, body in bodies.items():
        assert body.mass == pytest.approx(full.mass, rel=1e-12)
        assert body.inertia == pytest.approx(full.inertia, rel=1e-12)
        assert (body.stiffness >= full.stiffness[: body.modes] * (1.0 - 1e-8)).all(), name
    for name in ("whole boundary", "all fixed", "all of the rest", "all modes"):
        assert bodies[name].stiffness == pytest.approx(full.stiffness, rel=1e-7), name
    exact, some = full.locate(*mesh.places[nodes[0]]).phi, bodies["residual"].locate(*mesh.places[nodes[0]]).phi
    expected = exact.T @ (exact / full.stiffness[:, None])
    assert some.T @ (some / bodies["residual"].stiffness[:, None]) == pytest.approx(expected, abs=1e-9 * expected.max())
