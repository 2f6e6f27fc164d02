"""Two blocks pressed on each other by a uniform pressure: a patch test of the contact of faces of solids.

The stress is -p across the face and none besides, which every element can have: what is not that is of the contact.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from tests.pressed_solids import Part, centre_stress, grid_block, meet, press, touch_ground

E, NU, PRESSURE = 2e11, 0.3, 1e8
STEEL: dict[str, Any] = {"density": 7800.0, "youngs_modulus": E, "poissons_ratio": NU}
COARSER = "ignore:.*is the coarser face:lcpflex.ModelWarning"
LINEAR_TETRAHEDRA = "ignore:.*tetrahedra of four nodes:lcpflex.ModelWarning"
QUADRATIC = [pytest.param(kind, marks=pytest.mark.slow) for kind in ("tetra10", "hexahedron27")]


def cube(kind: str, n: int, low: float, edge: float) -> lf.Solid:
    """Of n elements an edge, from z = low edges on; tetrahedra are irregular unless ``n`` is 2."""
    line = np.linspace(0.0, edge, n + 1)
    skew = 0.2 if kind.startswith("tetra") and n > 2 else 0.0
    mesh = grid_block(kind, (line, line, line + low * edge), skew)
    return lf.Solid(mesh, **STEEL, sets={"contact": lambda x, y, z: np.abs(z) < 1e-9 * edge})


def exact(places: FloatArray) -> FloatArray:
    """(N, 3) displacements."""
    return PRESSURE / E * places * [NU, NU, -1.0]


def upper(solid: lf.Solid) -> Part:
    """Pressed at its top, symmetric about x = 0 and y = 0, free along z."""
    mesh = solid.finite_elements()
    held = np.column_stack([mesh.places[:, :2] == 0.0, np.zeros(len(mesh.places), dtype=bool)])
    load = (mesh.stiffness @ exact(mesh.places).ravel()).reshape(-1, 3)
    load[mesh.places[:, 2] < 0.999 * mesh.places[:, 2].max()] = 0.0
    return Part(solid, held.ravel(), load=(load * [0.0, 0.0, 1.0]).ravel(), loose=True)


def lower(solid: lf.Solid) -> Part:
    """On a plane without friction, symmetric about x = 0 and y = 0."""
    mesh = solid.finite_elements()
    bottom = mesh.places[:, 2] < 0.999 * mesh.places[:, 2].min()
    held = np.column_stack([mesh.places[:, :2] == 0.0, bottom])
    return Part(solid, held.ravel(), given=exact(mesh.places).ravel())


class Found(NamedTuple):
    """Largest and other errors of the two blocks, relative."""

    force: float
    pressure: float  # of a node or area
    stress: tuple[float, float]  # at centres of the elements at the face, of the upper and the lower block
    energy: float  # root of that of the errors of both, over the root of what both store
    displacement: float  # over that of the top


def pressed(kind: str, above: int, below: int, slave: int, by: str = "areas", edge: float = 1.0) -> Found:
    """Blocks of so many elements an edge; ``slave``: 0 the upper one, 1 the lower one."""
    solids = [cube(kind, above, 0.0, edge), cube(kind, below, -1.0, edge)]
    rows = meet(*solids, by, slave, 1e-3 * edge)
    found = press(rows, [upper(solids[0]), lower(solids[1])])
    whole = PRESSURE * edge**2
    pressures = found.force / rows.area
    stress, energy, away = [], 0.0, 0.0
    for solid, moved, n in zip(solids, found.moved, (above, below), strict=True):
        mesh = solid.finite_elements()
        at, sigma = centre_stress(solid, moved)
        first = np.abs(at[:, 2]) < edge / n
        stress.append(float(np.abs(sigma[first] / PRESSURE + 1.0).max()))
        error = moved - exact(mesh.places)
        error[:, 2] -= error[:, 2].mean() if solid is solids[0] else 0.0  # the upper one may be shifted
        energy += float(error.ravel() @ (mesh.stiffness @ error.ravel()))
        away = max(away, float(np.abs(error[:, 2]).max()))
    return Found(
        abs(float(found.force.sum()) / whole - 1.0),
        float(np.abs(pressures / PRESSURE - 1.0).max()),
        (stress[0], stress[1]),
        math.sqrt(energy / (2.0 * PRESSURE**2 / E * edge**3)),
        away * E / (PRESSURE * edge),
    )


@pytest.mark.filterwarnings(LINEAR_TETRAHEDRA)
@pytest.mark.parametrize(
    ("kind", "by"),
    [("hexahedron", "areas"), ("hexahedron", "nodes"), ("tetra", "nodes"), ("tetra", "areas"), ("tetra10", "areas"),
     ("hexahedron20", "areas"), ("hexahedron27", "areas")],
)  # fmt: skip
def test_matching_meshes_have_the_pressure_that_is_applied(kind: str, by: str) -> None:
    for edge in (1.0, 1e-3):
        found = pressed(kind, 2, 2, 0, by, edge)
        assert found.force < 1e-9
        assert found.pressure < 1e-6
        assert max(found.stress) < 1e-6


GROUND: dict[str, Any] = {
    "plane": lambda ground: ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "larger hull": lambda ground: ground.box((0.5, 0.4, -0.5), (1.5, 1.3, 1.0)),
    "equal hull": lambda ground: ground.box((0.5, 0.5, -0.5), (1.0, 1.0, 1.0)),
    "end of a cylinder": lambda ground: ground.cylinder((0.5, 0.5, -0.5), (0.0, 0.0, 1.0), 0.8, 1.0),
}


@pytest.mark.parametrize("ground", GROUND)
@pytest.mark.parametrize(("kind", "by"), [("hexahedron", "nodes"), ("hexahedron", "areas"), ("hexahedron27", "areas")])
def test_flat_ground_has_the_pressure_that_is_applied(kind: str, by: str, ground: str) -> None:
    solid = cube(kind, 2, 0.0, 1.0)
    rows = touch_ground(solid, GROUND[ground], by, 1e-3)
    found = press(rows, [upper(solid)])
    np.testing.assert_allclose(found.force / rows.area, PRESSURE, rtol=1e-6)
    np.testing.assert_allclose(centre_stress(solid, found.moved[0])[1], -PRESSURE, rtol=1e-6)
    np.testing.assert_allclose([rows.area.sum(), rows.share.sum()], 1.0, rtol=1e-12)


@pytest.mark.parametrize("kind", ["hexahedron", *QUADRATIC])
def test_stress_below_a_finer_slave(kind: str) -> None:
    """Within 1 % one element below the face, on both sides of it, whichever block is the finer one."""
    for above, below, slave in ((5, 3, 0), (3, 5, 1)):
        found = pressed(kind, above, below, slave)
        assert found.force < 1e-9
        assert max(found.stress) < 0.01


@pytest.mark.filterwarnings(COARSER)
@pytest.mark.parametrize("kind", ["hexahedron", *QUADRATIC])
def test_stress_below_a_coarser_slave(kind: str) -> None:
    found = pressed(kind, 3, 5, 0)
    assert found.force < 1e-9
    assert max(found.stress) < 0.03


def test_a_coarser_slave_is_told() -> None:
    with pytest.warns(lf.ModelWarning, match="is the coarser face, with sub-faces of"):
        pressed("hexahedron", 2, 3, 0)


@pytest.mark.slow
def test_nearly_equal_meshes_are_as_good_as_others() -> None:
    """10 on 9 elements an edge, and 9 on 10, which no warning calls coarser: parts are cut by the master anywhere."""
    assert max(pressed("hexahedron", 10, 9, 0).stress) < 0.01
    assert max(pressed("hexahedron", 10, 9, 1).stress) < 0.03


def test_nodes_on_another_mesh_are_no_patch_test() -> None:
    """Why areas are the default there: single nodes put errors of a tenth into the stress below."""
    assert max(pressed("hexahedron", 5, 3, 0, "nodes").stress) > 0.05


@pytest.mark.filterwarnings(COARSER)
@pytest.mark.parametrize("slave", [0, 1])
def test_error_against_the_size_of_elements(slave: int) -> None:
    """The error of the stress is within a layer of elements, whose thickness is h: energy ~ h^1/2, displacement ~ h."""
    coarse, fine = pressed("hexahedron", 5, 3, slave), pressed("hexahedron", 10, 6, slave)
    assert 0.4 < math.log2(coarse.energy / fine.energy) < 0.7
    assert 0.8 < math.log2(coarse.displacement / fine.displacement) < 1.2
    assert 0.8 < max(fine.stress) / max(coarse.stress) < 1.2  # in that layer it stays
