"""Solids of every kind of element: frequencies, integrals, momenta, equations of motion, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.fem.assembly import ElasticSolid, lame_constants, stiffness_matrix
from lcpflex.bodies.reduction.eigenmodes import FreeMesh
from lcpflex.bodies.spatial.checks import skew
from lcpflex.jit.kernel import FloatArray
from tests import libs
from tests.solid_meshes import EDGES, QUIET, SOLIDS, STEEL, bent, meshed_block, solid
from tests.spatial_inertia import velocity_columns

HZ = 2.0 * math.pi


@QUIET
@pytest.mark.parametrize("kind", SOLIDS)
def test_stiffness_is_symmetric_and_resists_no_rigid_motion(kind: str) -> None:
    mesh = solid(kind, bend=bent).finite_elements()
    scale = abs(mesh.stiffness).max()
    assert abs(mesh.stiffness - mesh.stiffness.T).max() == 0.0
    assert np.abs(mesh.stiffness @ mesh.rigid).max() < 1e-14 * scale
    assert np.linalg.eigvalsh(mesh.stiffness.toarray())[6] > 1e-9 * scale


@QUIET
@pytest.mark.parametrize("kind", SOLIDS)
def test_uniform_strain_is_exact_in_elements_of_any_form(kind: str) -> None:
    """The patch test: its energy is that of the volume, and no force acts inside."""
    strain = 1e-3 * np.array([[1.0, 0.3, 0.2], [0.3, -0.5, 0.7], [0.2, 0.7, 2.0]])
    moved = 0.02 * np.random.default_rng(3).uniform(-1.0, 1.0, 3)

    def distorted(places: FloatArray) -> FloatArray:
        inside = ((places > 1e-9) & (places < np.array(EDGES) - 1e-9)).all(axis=1)
        return np.asarray(places + np.where(inside[:, None], moved, 0.0))

    counts = (2, 2, 2)
    linear = kind in ("tetra", "hexahedron")
    mesh = solid(kind, counts, distorted if linear else None).finite_elements()
    field = (mesh.places @ strain).ravel()
    L, G = lame_constants(STEEL["youngs_modulus"], STEEL["poissons_ratio"], False)
    density = L * np.trace(strain) ** 2 + 2.0 * G * (strain**2).sum()
    force = mesh.stiffness @ field
    assert field @ force == pytest.approx(density * math.prod(EDGES), rel=1e-12)
    inner = np.setdiff1d(np.arange(len(mesh.places)), mesh.sets["surface"])
    assert np.abs(force.reshape(-1, 3)[inner]).max() < 1e-11 * np.abs(force).max()


@pytest.mark.parametrize(
    ("kind", "counts", "bending", "stretch"),
    [
        ("hexahedron", (20, 2, 2), 6.2e-3, 1.28e-3),
        ("hexahedron20", (10, 1, 1), 2.7e-3, 7e-6),
        ("hexahedron27", (10, 1, 1), 2.7e-3, 7e-6),
        ("tetra10", (10, 1, 1), 3.4e-3, 1.1e-5),
    ],
)
def test_frequencies_of_a_free_bar(kind: str, counts: tuple[int, int, int], bending: float, stretch: float) -> None:
    """First bending 2568.2 Hz (Timoshenko) within .7 %, longitudinal 12920.9 Hz (Love)."""
    hertz = lf.Solid(meshed_block(kind, (0.2, 0.02, 0.02), counts), **STEEL).reduce(8).frequencies() / HZ
    assert hertz[0] / 2568.2 - 1.0 == pytest.approx(bending, rel=0.05)
    assert hertz[7] / 12920.9 - 1.0 == pytest.approx(stretch, abs=2e-6, rel=0.05)


def test_incompatible_modes_converge_with_the_square_of_the_size() -> None:
    error = []
    for n in (1, 2, 4):
        mesh = meshed_block("hexahedron", (0.2, 0.02, 0.02), (10 * n, n, n))
        error.append(
            lf.Solid(mesh, **STEEL).reduce(1).frequencies()[0] / HZ / 2569.1 - 1.0
        )  # 27 nodes, 30 x 3 x 3: 2569.18
    rates = np.log2(np.array(error[:-1]) / error[1:])
    assert 1.4 < rates.min() <= rates.max() < 2.3  # 1.6, 1.9


def test_a_square_plate_vibrates_as_plates_do() -> None:
    """A free thin square plate: 13.468, 19.596, 24.270 (Leissa 1973; nu = .3) of sqrt(D / rho h) / a^2."""
    a, h = 0.2, 0.002
    plate = lf.Solid(meshed_block("hexahedron", (a, a, h), (16, 16, 1)), **STEEL)
    D = STEEL["youngs_modulus"] * h**3 / (12.0 * (1.0 - 0.3**2))
    unit = math.sqrt(D / (STEEL["density"] * h)) / a**2
    assert plate.reduce(3).frequencies() / unit == pytest.approx([13.468, 19.596, 24.270], rel=8e-3)


def test_a_twisting_bar_and_a_breathing_ball() -> None:
    """Torsion of a round bar, sqrt(G / rho) / 2 L; breathing of a ball, omega = k c / R (Love; k = 2.6702)."""
    rod = lf.Solid.cylinder(0.01, 0.2, 0.004, **STEEL)
    shear = math.sqrt(STEEL["youngs_modulus"] / 2.6 / STEEL["density"])
    twist = rod.reduce(8).frequencies() / HZ
    assert np.abs(twist / (shear / 0.4) - 1.0).min() < 2e-3
    R = 0.02
    L, G = lame_constants(STEEL["youngs_modulus"], STEEL["poissons_ratio"], False)
    sound = math.sqrt((L + 2.0 * G) / STEEL["density"])
    ball = lf.Solid.ball(R, 0.007, **STEEL).reduce(60)
    phi = ball.shape.phi  # type: ignore[union-attr]
    radial = np.einsum("ikj,ij->k", phi, ball.shape.vertices)  # type: ignore[union-attr]
    breathing = int(np.abs(radial).argmax())
    k = _breathing(STEEL["poissons_ratio"])
    assert k == pytest.approx(2.6702, abs=1e-4)
    assert ball.frequencies()[breathing] / (k * sound / R) - 1.0 == pytest.approx(1.73e-2, rel=0.1)  # a polyhedron


def _breathing(nu: float) -> float:
    """Least k > 0 of tan k = k / (1 - k^2 (1 - nu) / (2 (1 - 2 nu)))."""
    from scipy.optimize import brentq

    quarter = (1.0 - nu) / (2.0 * (1.0 - 2.0 * nu))
    return float(brentq(lambda k: math.sin(k) * (1.0 - quarter * k * k) - k * math.cos(k), 1.5, 3.1))


@QUIET
@pytest.mark.parametrize("kind", SOLIDS)
def test_inertia_of_a_block_is_exact_to_rounding(kind: str) -> None:
    m = STEEL["density"] * math.prod(EDGES)
    body = solid(kind).reduce(0)
    assert body.mass == pytest.approx(m, rel=1e-13)
    assert body.second == pytest.approx(m / 12.0 * np.diag(np.square(EDGES)), rel=1e-12, abs=1e-13 * m)


@QUIET
@pytest.mark.parametrize("kind", SOLIDS)
def test_inertia_of_a_bent_block_is_that_of_finer_quadrature(kind: str) -> None:
    """Curved elements included: sums over 8 points along each edge of det J and x x^T det J."""
    given = solid(kind, bend=bent)
    mesh = given.finite_elements().solid.mesh  # type: ignore[union-attr]
    element = getattr(libs.skfem, mesh.kind.element)()
    X, weight = libs.skfem.quadrature.get_quadrature(element, 8 if mesh.kind.simplex else 12)
    from lcpflex.bodies.fem.assembly import shape_functions

    N, dN = shape_functions(mesh.kind, X)
    corners = mesh.places[mesh.cells]
    at = np.einsum("mni,qn->mqi", corners, N)
    dm = STEEL["density"] * weight * np.linalg.det(np.einsum("mni,qnj->mqij", corners, dN))
    body = given.reduce(0)
    centre = np.einsum("mq,mqi->i", dm, at) / dm.sum()
    second = np.einsum("mq,mqi,mqj->ij", dm, at - centre, at - centre)
    assert body.mass == pytest.approx(dm.sum(), rel=1e-12)
    assert body.origin == pytest.approx(centre, rel=1e-12)
    assert body.second == pytest.approx(second, rel=1e-11, abs=1e-12 * np.trace(second))


def test_inertia_of_a_cylinder_converges_and_is_that_of_its_faces() -> None:
    """The polyhedron of its outer faces has the same volume and second moments."""
    error = []
    for size in (0.02, 0.01, 0.005):
        body = lf.Solid.cylinder(0.02, 0.05, size, **STEEL).reduce(0)
        exact = STEEL["density"] * math.pi * 0.02**4 * 0.05 / 2.0
        error.append(1.0 - body.inertia[2, 2] / exact)
        hull = lf.ConvexHull(body.shape.vertices, density=STEEL["density"])  # type: ignore[union-attr]
        assert body.mass == pytest.approx(hull.mass, rel=1e-12)
        assert body.second == pytest.approx(hull.second, rel=1e-11, abs=1e-13 * np.trace(hull.second))
    rates = np.log2(np.array(error[:-1]) / error[1:])
    assert 1.3 < rates.min() <= rates.max() < 2.7  # numbers of elements around are whole


@QUIET
@pytest.mark.parametrize("kind", SOLIDS)
@pytest.mark.parametrize("clamped", [False, True])
def test_equations_of_motion_are_those_of_all_nodes(kind: str, clamped: bool) -> None:
    """L^T (M_FE a + K d) = 0 with the accelerations a of the nodes by the motion that the library finds."""
    given = solid(kind, bend=bent, sets={"foot": lambda x, y, z: np.arange(len(x)) < 6})
    held = "foot" if clamped else None
    body = given.reduce(4, clamped=held)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    rng = np.random.default_rng(5)
    scene.add(body, velocity=rng.normal(size=3), angular_velocity=30.0 * rng.normal(size=3),
              modal=1e-3 * rng.normal(size=4), modal_velocity=5.0 * rng.normal(size=4))  # fmt: skip
    at = scene.compile().at()
    udot = np.linalg.solve(at.M, at.h)
    q, u = at.q, at.u
    mesh = given.finite_elements()
    x, phi, eta = mesh.places - body.origin, body.shape.phi, q[7:]  # type: ignore[union-attr]
    A = _axes(q[3:7])
    s = x + np.einsum("ikj,k->ij", phi, eta)
    omega, rate = u[3:6], u[6:]
    in_body = (
        A.T @ udot[:3]
        + np.cross(udot[3:6], s)
        + np.cross(omega, np.cross(omega, s))
        + 2.0 * np.cross(omega, np.einsum("ikj,k->ij", phi, rate))
        + np.einsum("ikj,k->ij", phi, udot[6:])
    )
    L = velocity_columns(x, phi, eta)
    inertial = L.T @ (mesh.mass @ in_body.ravel())
    inertial[6:] += body.stiffness * eta
    size = np.abs(L.T @ (mesh.mass @ np.cross(omega, np.cross(omega, s)).ravel())).max()
    assert np.abs(inertial).max() < 1e-8 * size


def _axes(p: FloatArray) -> FloatArray:
    v = skew(p[1:])
    return np.eye(3) + 2.0 * p[0] * v + 2.0 * v @ v


@QUIET
@pytest.mark.parametrize("kind", ["tetra10", "hexahedron"])
def test_momenta_of_a_solid_that_flies_and_turns_are_kept(kind: str) -> None:
    body = solid(kind).reduce(6)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    scene.add(body, name="a", velocity=(1.0, 2.0, 3.0), angular_velocity=(20.0, 100.0, 5.0))
    result = lf.simulate(scene, 2e-3, lf.EventDriven(rtol=1e-12), progress=False)
    momentum = result.momentum()
    for values in (momentum.linear, momentum.angular):
        assert np.abs(values - values[0]).max() < 1e-10 * np.abs(values[0]).max()
    assert np.abs(result.q[:, 7:]).max() > 1e-7 * math.sqrt(body.mass)  # and it deforms


@QUIET
def test_points_between_nodes_and_weighted_sets() -> None:
    """A set that is finely meshed at one end has its mean amid the face, and places between nodes follow a field."""
    lines = (np.linspace(0.0, 0.3, 4), np.array([0.0, 0.002, 0.01, 0.05, 0.2]), np.linspace(0.0, 0.1, 3))
    body = lf.Solid(libs.skfem.MeshHex.init_tensor(*lines), **STEEL, sets={
        "end": lambda x, y, z: x < 1e-9,
        "edge": lambda x, y, z: (x < 1e-9) & (z < 1e-9),
        "slab": lambda x, y, z: x < 0.11,
    }).reduce(4)  # fmt: skip
    assert body.points["end"].place + body.origin == pytest.approx([0.0, 0.1, 0.05], abs=1e-12)
    assert body.points["edge"].place + body.origin == pytest.approx([0.0, 0.1, 0.0], abs=1e-12)
    assert body.points["slab"].place + body.origin == pytest.approx([0.05, 0.1, 0.05], abs=1e-12)
    nodes = body.shape.vertices  # type: ignore[union-attr]
    a, b = (int(np.linalg.norm(nodes + body.origin - at, axis=1).argmin()) for at in ([0.1, 0, 0], [0.2, 0, 0]))
    middle = body.locate(*(0.5 * (nodes[a] + nodes[b])))
    phi = body.shape.phi  # type: ignore[union-attr]
    assert middle.phi == pytest.approx(0.5 * (phi[a] + phi[b]), abs=1e-12)


def test_rows_along_normals_are_those_of_the_matrices() -> None:
    """The compliance at contact nodes along normals is that of the whole mesh, by residual or by constraint modes."""
    given = solid("tetra10", (4, 3, 2), bent, sets={"tip": lambda x, y, z: x > 0.3})
    mesh = given.finite_elements()
    assert "tip" not in mesh.faces  # nodes on a bent face are chosen by their places: some faces of it
    nodes = mesh.sets["tip"]
    whole = lf.unreduced(given)
    normals = _normals(given, nodes)

    def compliance(body: lf.SpatialBody) -> FloatArray:
        rows = np.einsum("ikj,ij->ik", body.shape.phi[nodes], normals)  # type: ignore[union-attr]
        return np.asarray(rows / body.stiffness @ rows.T)

    exact = compliance(whole)
    residual = given.reduce(4, contact="tip", rows="normal")
    assert residual.residual_modes == len(nodes)
    assert np.abs(compliance(residual) - exact).max() < 1e-6 * np.abs(exact).max()
    few = given.reduce(4)
    assert np.abs(compliance(few) - exact).max() > 0.1 * np.abs(exact).max()


def _normals(given: lf.Solid, nodes: Any) -> FloatArray:
    from lcpflex.bodies.reduction.normal_rows import nodal_normals

    return nodal_normals(given.finite_elements(), "contact", nodes)


@QUIET
@pytest.mark.parametrize("kind", ["tetra10", "hexahedron"])
def test_boundary_rows_along_normals_keep_the_frequencies(kind: str) -> None:
    """Frequencies fall to those of the mesh with more modes, whichever rows are kept."""
    mesh = meshed_block(kind, EDGES, (4, 3, 2))
    given = lf.Solid(mesh, **STEEL, sets={"tip": lambda x, y, z: x > 0.3 - 1e-9})
    exact = given.reduce(5).frequencies()
    nodes = len(given.finite_elements().sets["tip"])
    last = math.inf
    for modes in (3, 9, 27):
        body = given.reduce(modes, boundary="tip", rows="normal")
        assert body.modes == modes + nodes - 3  # the flat face leaves three rigid motions, and three are in its rows
        excess = float((body.frequencies()[:5] / exact - 1.0).max())
        assert -1e-9 < excess < last
        last = excess
    assert last < 5e-3
    assert np.abs(given.reduce(None, boundary="tip", rows="normal").frequencies()[:5] / exact - 1.0).max() < 1e-7


def test_tetrahedra_of_four_nodes_are_warned_of() -> None:
    with pytest.warns(lf.ModelWarning, match="tetrahedra of four nodes are far too stiff"):
        solid("tetra")


def test_stiffness_errors_are_told_as_in_the_plane() -> None:
    """By the next finer mesh, and by an estimate that warns."""
    for kind, counts, told in (("hexahedron", (20, 2, 2), 0.013), ("tetra10", (10, 1, 1), 7e-3)):
        given = lf.Solid(meshed_block(kind, (0.2, 0.02, 0.02), counts), **STEEL)
        exact = (given.reduce(1).frequencies()[0] / HZ / 2569.1) ** 2 - 1.0
        assert given.stiffness_error() > 0.8 * exact
        assert exact < told
    with pytest.warns(lf.ModelWarning, match="four nodes"), pytest.warns(lf.ModelWarning, match="too high"):
        lf.Solid(meshed_block("tetra", (0.2, 0.02, 0.02), (20, 2, 2)), **STEEL).reduce(3)


@pytest.mark.parametrize(
    ("kind", "edges", "counts", "least"),
    [
        ("hexahedron", (0.3, 0.2, 0.1), (3, 2, 1), 0.5),
        ("hexahedron", (0.2, 0.02, 0.02), (10, 1, 1), 0.35),
        ("hexahedron", (0.2, 0.2, 0.002), (4, 4, 1), 0.4),
        ("hexahedron27", (0.2, 0.2, 0.002), (3, 3, 1), 0.4),
        ("hexahedron27", (0.2, 0.02, 0.02), (3, 1, 1), 0.5),
        ("tetra10", (0.2, 0.02, 0.02), (10, 1, 1), 0.25),
        ("tetra", (0.2, 0.02, 0.02), (20, 2, 2), 0.7),
    ],
)
@QUIET
def test_the_estimate_is_most_of_the_excess_and_no_more(
    kind: str, edges: tuple[float, float, float], counts: tuple[int, int, int], least: float
) -> None:
    """Of the stiffest of three modes, against the next finer mesh."""
    mesh = lf.Solid(meshed_block(kind, edges, counts), **STEEL).finite_elements()
    omega2, shapes = FreeMesh.of(mesh).modes(3)
    told = mesh.excess(omega2, shapes)  # type: ignore[misc]
    excess = omega2 / FreeMesh.of(mesh.finer()).modes(3)[0] - 1.0  # type: ignore[misc]
    assert least < told.max() / excess.max() < 1.05


@QUIET
@pytest.mark.parametrize("kind", SOLIDS)
def test_the_finer_mesh_is_of_the_same_body(kind: str) -> None:
    mesh = solid(kind, (2, 2, 1), bent).finite_elements()
    fine = mesh.finer()  # type: ignore[misc]
    assert fine.mass.sum() == pytest.approx(mesh.mass.sum(), rel=1e-12)
    stretched = [(one.places * [3e-4, -2e-4, 1e-4]).ravel() for one in (mesh, fine)]
    energy = [v @ one.stiffness @ v for v, one in zip(stretched, (mesh, fine), strict=True)]
    assert energy[1] == pytest.approx(energy[0], rel=1e-9)


@pytest.mark.parametrize("scale", [1e-6, 1e4])
@pytest.mark.parametrize("kind", ["tetra10", "hexahedron"])
@QUIET
def test_frequencies_scale_with_the_size(kind: str, scale: float) -> None:
    small = lf.Solid(meshed_block(kind, EDGES, (3, 2, 1), lambda p: scale * (p + 100.0)), **STEEL)
    assert scale * small.reduce(5).frequencies() == pytest.approx(solid(kind).reduce(5).frequencies(), rel=1e-9)


def test_stiffness_of_elements_of_odd_numbers_is_summed_in_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = meshed_block("hexahedron", EDGES, (5, 3, 2), bent)
    given = ElasticSolid(mesh, 1.0, (2.0, 1.0), 1.0)
    whole = stiffness_matrix(given)
    monkeypatch.setattr("lcpflex.bodies.fem.assembly.AT_ONCE", 2000)
    assert abs(stiffness_matrix(given) - whole).max() < 1e-15 * abs(whole).max()


@QUIET
@pytest.mark.parametrize(("kind", "counts"), [("tetra10", (3, 2, 1)), ("hexahedron", (4, 3, 2))])
def test_every_reduction_of_the_plane_takes_solids(kind: str, counts: tuple[int, int, int]) -> None:
    """Frequencies fall to those of the mesh; static compliance in the region is exact but for the published basis."""
    given = solid(kind, counts, sets={"tip": lambda x, y, z: x > 0.19})
    exact, nodes = lf.unreduced(given), given.finite_elements().sets["tip"]

    def compliance(body: lf.SpatialBody) -> FloatArray:
        rows = body.shape.phi[nodes].transpose(0, 2, 1).reshape(3 * len(nodes), -1)  # type: ignore[union-attr]
        return np.asarray(rows / body.stiffness @ rows.T)

    whole = compliance(exact)
    reductions: dict[str, Any] = {
        "craig_bampton": lambda n: lf.craig_bampton(given, "tip", n),
        "residual": lambda n: lf.residual_compliance(given, "tip", n),
        "region": lambda n: lf.sub_regional(given, "tip", n),
        "published": lambda n: lf.sub_regional(given, "tip", n, interface_modes=False),
    }
    for name, reduce in reductions.items():
        few, many = reduce(4), reduce(40)
        excess = [float((body.frequencies()[:4] / exact.frequencies()[:4] - 1.0).max()) for body in (few, many)]
        assert -1e-8 < excess[1] < max(excess[0], 1e-9)
        assert excess[1] < (
            0.05 if name == "published" else 5e-3
        )  # they fall like modes^-1 as published, else like modes^-3
        error = np.abs(compliance(few) - whole).max() / np.abs(whole).max()
        if name in ("residual", "region"):  # for loads with a resultant, too
            assert error < 1e-6
        if name == "published":
            assert error > 1e-2
    assert np.abs(lf.craig_bampton(given, "tip", 4).second / exact.second - 1.0)[np.eye(3, dtype=bool)].max() < 1e-12


@QUIET
def test_a_solid_says_how_large_its_mesh_is_and_not_where_its_nodes_are() -> None:
    said = repr(lf.Solid.box((0.3, 0.2, 0.1), elements=(3, 2, 1), **STEEL))
    assert said.startswith("Solid(mesh=<mesh: 24 nodes, 6 elements of kind 'hexahedron'>, density=")
