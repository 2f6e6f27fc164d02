"""Bodies with residual modes at interfaces: statically the mesh where they are held, loaded and struck."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

import lcpflex as lf
from lcpflex.bodies.body import Body, MaterialPoint
from lcpflex.dynamics.mass_matrix import null_space

E, RHO = 2.1e11, 7800.0
BEAM = lf.Beam(1.0, 0.02, 0.01, RHO, E)
EI = E * 0.02 * 0.01**3 / 12.0
EA = E * 0.02 * 0.01
MASS = RHO * 0.02 * 0.01


def shapes(point: MaterialPoint) -> np.ndarray:
    """(n, 3) of forces along x and y and of a moment."""
    return np.column_stack([point.phi, point.psi])


def compliance(body: Body, *points: MaterialPoint) -> np.ndarray:
    """Of deformation, at unit forces and moments at the points, balanced by inertia."""
    loads = np.hstack([shapes(point) for point in points])
    return np.asarray(loads.T @ (loads / body.stiffness[:, None]))


def relative(a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference, each entry by the roots of its diagonal ones."""
    size = np.sqrt(np.diag(b))
    size = np.outer(size, size)
    return float((np.abs(a - b)[size > 0.0] / size[size > 0.0]).max())


def held(body: Body, constraints: np.ndarray, force: np.ndarray) -> tuple[np.ndarray, float]:
    """Angular frequencies of the body held by rows of ``constraints``, and its compliance at the load ``force``."""
    n = len(body.stiffness)
    M = np.eye(3 + n)
    M[:2, :2] *= body.mass
    M[:2, 2] = M[2, :2] = [-body.moment[1], body.moment[0]]
    M[2, 2], M[2, 3:], M[3:, 2] = body.inertia, body.c, body.c
    M[:2, 3:], M[3:, :2] = body.S.T, body.S
    K = np.diag(np.concatenate([np.zeros(3), body.stiffness]))
    scale = 1.0 / np.sqrt(np.diag(M))
    Z = scale[:, None] * null_space(constraints * scale)
    stiff = Z.T @ K @ Z
    omega2 = eigh(stiff, Z.T @ M @ Z, eigvals_only=True)
    soft = float(force @ Z @ np.linalg.solve(stiff, Z.T @ force)) if force.any() else 0.0
    return np.sqrt(np.maximum(omega2, 0.0)), soft


def rows(point: MaterialPoint) -> np.ndarray:
    """(3, 3 + n) velocity and rate of rotation of a point, by all velocities, undeformed."""
    x, y = point.place
    rigid = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
    return np.hstack([rigid, shapes(point).T])


@pytest.mark.parametrize("modes", [0, 3, 8, 20])
@pytest.mark.parametrize("places", [["left"], ["left", "right"], [0.3, "center", (0.77, 0.004)], [0.0, 0.005, 0.01]])
def test_compliance_of_a_beam_is_that_of_its_mesh(modes: int, places: list[Any]) -> None:
    """At every interface, in all three directions and between them; 12 % of rotation are missing without."""
    body, mesh = BEAM.reduce(modes, interfaces=places), BEAM.reduce(None)
    assert modes < len(body.stiffness) <= modes + 3 * len(places)
    at = [p if isinstance(p, tuple) else ({"left": 0.0, "center": 0.5, "right": 1.0}.get(p, p), 0.0) for p in places]
    ours, theirs = (compliance(b, *(b.locate(x, y) for x, y in at)) for b in (body, mesh))
    assert relative(ours, theirs) < 1e-9
    np.testing.assert_allclose(body.stiffness[:modes], BEAM.reduce(modes).stiffness, rtol=1e-12)
    assert (np.diff(body.stiffness[modes:]) >= 0.0).all()


def test_residual_modes_are_modes_of_the_free_beam() -> None:
    """Orthonormal, without rigid motion, with a diagonal stiffness, in terms of the mesh's own modes."""
    body, mesh = BEAM.reduce(5, interfaces=["left", 0.37]), BEAM.reduce(None)
    stations = np.linspace(0.0, 1.0, 41)
    ours, theirs = (np.vstack([shapes(b.locate(x, 0.0)).T for x in stations]) for b in (body, mesh))
    turn, *_ = np.linalg.lstsq(theirs, ours, rcond=None)  # our modes in those of the mesh
    np.testing.assert_allclose(theirs @ turn, ours, atol=1e-9 * np.abs(ours).max())
    np.testing.assert_allclose(turn.T @ turn, np.eye(len(body.stiffness)), atol=1e-9)
    K = turn.T @ (mesh.stiffness[:, None] * turn)
    np.testing.assert_allclose(K, np.diag(body.stiffness), atol=1e-9 * body.stiffness.max())


@pytest.mark.parametrize(("places", "tip"), [(["left"], 1e-3), (["left", "right"], 1e-9)])
def test_a_welded_beam_with_eight_modes(places: list[str], tip: float) -> None:
    """First frequency and static tip: 9.8 % and -13 % without residual modes."""
    body = BEAM.reduce(8, interfaces=places)
    plain = BEAM.reduce(8)
    end = body.points["right"]
    omega, soft = held(body, rows(body.points["left"]), rows(end)[1])
    first = 1.875104068711961**2 * math.sqrt(EI / MASS)
    assert omega[0] == pytest.approx(first, rel=1e-6)
    assert omega[1] == pytest.approx(4.694091132974175**2 * math.sqrt(EI / MASS), rel=1e-3)
    assert soft == pytest.approx(1.0 / (3.0 * EI), rel=tip)
    assert held(plain, rows(plain.points["left"]), rows(plain.points["right"])[1])[0][0] > 1.09 * first


def test_a_welded_beam_in_a_scene() -> None:
    """Released under its weight: about rho A g L^4 / (8 E I), and back after 2 pi / omega_1."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    beam = scene.add(BEAM.reduce(8, interfaces=["left"]), name="beam")
    scene.join(lf.Weld(beam.point("left"), scene.ground.at(0.0, 0.0)))
    period = 2.0 * math.pi / (1.875104068711961**2 * math.sqrt(EI / MASS))
    result = lf.simulate(scene, 10.0 * period, lf.MoreauJean(step=period / 1000.0), record=period / 100.0)
    tip = result.point("beam", (1.0, 0.0))[:, 1]
    assert tip.mean() == pytest.approx(-MASS * 9.81 / (8.0 * EI), rel=5e-3)
    assert np.abs(tip[::100]).max() < 0.03 * np.abs(tip).max()


@pytest.mark.parametrize("place", ["left", 0.25])
def test_pinned_beams(place: Any) -> None:
    """A beam pinned at one place and free elsewhere, beside all modes of its mesh."""
    body, mesh, plain = BEAM.reduce(8, interfaces=[place]), BEAM.reduce(None), BEAM.reduce(8)
    x = 0.0 if place == "left" else place
    omega, exact, without = (
        held(b, rows(b.locate(x, 0.0))[:2], np.zeros(3 + len(b.stiffness)))[0] for b in (body, mesh, plain)
    )
    np.testing.assert_allclose(omega[1:4], exact[1:4], rtol=1e-4)
    assert without[2] > exact[2] * 1.0005


def test_bars() -> None:
    """Clamped at one end: quarter-wave frequencies, and L / (E A) at the other, both to the mesh's own."""
    bar = lf.Bar(1.0, 2e-4, RHO, E, elements=50)
    body, mesh = bar.reduce(4, interfaces=["left", "right"]), bar.reduce(None)
    assert len(body.stiffness) == 6
    for end in ("left", "right"):
        soft, exact = (compliance(b, b.points[end])[0, 0] for b in (body, mesh))
        assert soft == pytest.approx(exact, rel=1e-9)
    omega, soft = held(body, rows(body.points["left"]), rows(body.points["right"])[0])
    assert omega[0] == pytest.approx(0.5 * math.pi * math.sqrt(E / RHO), rel=1e-3)
    assert soft == pytest.approx(1.0 / EA, rel=1e-9)


@pytest.mark.parametrize("kind", ["continuum", "matrices"])
def test_meshes(kind: str) -> None:
    """Matrices and meshes: at nodes that are named or numbered."""
    mesh = lf.meshes.bar(0.3, 0.02, 30)
    plate = lf.Continuum(mesh, density=2700.0, youngs_modulus=7e10, poissons_ratio=0.33, thickness=0.02)
    model: Any = plate
    if kind == "matrices":
        parts = plate.finite_elements()
        model = lf.Matrices(parts.mass, parts.stiffness, parts.places, node_sets={"right": parts.sets["right"]})
    nodes = plate.finite_elements().sets["right"]
    for interfaces in ("right", nodes.tolist()):
        body, whole = model.reduce(6, interfaces=interfaces), model.reduce(None)
        assert 6 < len(body.stiffness) <= 6 + 2 * len(nodes)
        places = plate.finite_elements().places[nodes]
        ours, theirs = (np.hstack([b.locate(x, y).phi for x, y in places]).T for b in (body, whole))
        soft, exact = ((p / b.stiffness) @ p.T for p, b in ((ours, body), (theirs, whole)))
        assert relative(soft, exact) < 1e-9


def test_damping_of_residual_modes() -> None:
    """A ratio for all, the last of several, Rayleigh's by frequency."""
    one = BEAM.reduce(2, 0.05, interfaces=["left"])
    np.testing.assert_allclose(one.damping, 0.1 * np.sqrt(one.stiffness))
    several = BEAM.reduce(2, [0.01, 0.03], interfaces=["left"])
    ratios = several.damping / (2.0 * np.sqrt(several.stiffness))
    np.testing.assert_allclose(ratios, [0.01, *[0.03] * (len(ratios) - 1)])
    rayleigh = BEAM.reduce(2, lf.Rayleigh(1.0, 1e-5), interfaces=["left"])
    np.testing.assert_allclose(rayleigh.damping, 1.0 + 1e-5 * rayleigh.stiffness)


def test_stiffened_beams_keep_their_residual_modes() -> None:
    """Under an axial force the static response is that of the stretched beam; spun, the geometric terms know them."""
    pulled = lf.Stiffening(axial_force=1e3, between=("left", "right"))
    body, mesh = (BEAM.reduce(k, stiffening=pulled, **more) for k, more in ((6, {"interfaces": ["left"]}), (None, {})))
    assert relative(*(compliance(b, b.points["left"]) for b in (body, mesh))) < 1e-9
    spun = BEAM.reduce(6, stiffening=lf.Stiffening(), interfaces=["left"])
    assert spun.geometric is not None
    assert spun.geometric.shape == (len(spun.stiffness),) * 2


def test_no_interfaces_and_no_modes_left() -> None:
    plain, none = BEAM.reduce(8), BEAM.reduce(8, interfaces=[])
    np.testing.assert_array_equal(plain.stiffness, none.stiffness)
    everything = lf.Beam(1.0, 0.02, 0.01, RHO, E, elements=3)
    assert len(everything.reduce(None, interfaces=["left"]).stiffness) == 9


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (3.0, "interfaces: 3.0 was given, expected a list of places"),
        (["top"], r"interfaces\[0\]: 'top' was given, expected the name of a point"),
        ([0.5, 1.5], r"interfaces\[1\]: x: 1.5 was given"),
        ([(0.5, 0.2)], r"interfaces\[0\]: y: 0.2 was given"),
        ([(0.5, 0.0, 1.0)], r"interfaces\[0\]: place: an array of shape \(3,\) was given"),
        ([math.nan], r"interfaces\[0\]: place: nan was given"),
        ([None], r"interfaces\[0\]: "),
    ],
)
def test_places_that_are_none_are_refused(given: Any, said: str) -> None:
    for body in (BEAM, lf.Bar(1.0, 2e-4, RHO, E)):
        with pytest.raises(lf.ModelError, match=said):
            body.reduce(4, interfaces=given)
