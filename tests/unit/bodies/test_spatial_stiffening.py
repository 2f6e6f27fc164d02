"""Geometric stiffening of beams of space: columns and strings, displacements of second order, and what is refused."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray

pytestmark = pytest.mark.filterwarnings("ignore:youngs_modulus")  # unit beams are of no material

SIDE = 0.02
AREA = SIDE * SIDE
INERTIA = AREA * AREA / 12.0
EULER = math.pi**2  # of bending in xy; twice that in xz
POLAR = 3.0 * INERTIA


def unit_beam(elements: int = 20, shear_factor: Any = None) -> lf.SpatialBeam:
    """E I_z = rho A = L = 1, twice as stiff in xz; G I_t = .5."""
    return lf.SpatialBeam(
        1.0, AREA, (2.0 * INERTIA, INERTIA), 1.25 * INERTIA, 1.0 / AREA, 1.0 / INERTIA, shear_modulus=0.4 / INERTIA,
        shear_factor=shear_factor, elements=elements,
    )  # fmt: skip


def pinned(body: SpatialBody) -> FloatArray:
    """omega^2 of a beam whose ends are held across and in torsion, and one of them along."""
    n = body.modes
    M = np.diag([*[body.mass] * 3, *np.diag(body.inertia), *[1.0] * n])
    K = np.diag([*[0.0] * 6, *body.stiffness])
    rows = []
    for name, held in (("left", "xyzt"), ("right", "yzt")):
        point = body.points[name]
        x = point.place
        move = np.hstack([np.eye(3), -np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]]), point.phi.T])
        turn = np.concatenate([[0, 0, 0, 1, 0, 0], point.psi[:, 0]])
        rows += [turn if part == "t" else move["xyz".index(part)] for part in held]
    J = np.array(rows)
    _, sizes, vectors = np.linalg.svd(J / np.sqrt(np.diag(M)))
    Z = vectors[len(sizes) :].T / np.sqrt(np.diag(M))[:, None]
    return np.linalg.eigvalsh(Z.T @ K @ Z)


@pytest.mark.parametrize("force", [-0.99 * EULER, -5.0, 0.0, 100.0])
def test_pinned_beam_under_axial_force(force: float) -> None:
    """omega^2 = (I (k pi)^4 + N (k pi)^2) / (1 + I_z / A (k pi)^2) in either plane, and (G I_t + N r^2) of torsion."""
    found = pinned(unit_beam(40).reduce(None, stiffening=lf.Stiffening(axial_force=force)))
    k = math.pi * np.arange(1, 4)
    for rigidity, moment in ((1.0, INERTIA), (2.0, 2.0 * INERTIA)):
        expected = (rigidity * k**4 + force * k**2) / (1.0 + moment / AREA * k**2)
        for one, bending in zip(expected, rigidity * k**4, strict=True):
            assert np.abs(found - one).min() < 1e-5 * bending
    step = math.pi / 40  # of linear elements with consistent mass
    discrete = 6.0 * (1.0 - math.cos(step)) / (2.0 + math.cos(step)) * 40**2
    torsion = (0.5 + force * POLAR / AREA) / (POLAR / AREA) * discrete
    assert np.abs(found / torsion - 1.0).min() < 1e-9


def test_beam_buckles_in_its_weaker_plane() -> None:
    for clamped in (None, "left"):
        for modes in (0, 4):
            unit_beam().reduce(modes, clamped=clamped, stiffening=lf.Stiffening(axial_force=-0.999 * EULER))
            with pytest.raises(ModelError, match=r"axial_force: -9.8\d+ was given.*buckles"):
                unit_beam().reduce(modes, clamped=clamped, stiffening=lf.Stiffening(axial_force=-1.001 * EULER))


def test_axial_force_between_two_places() -> None:
    """A half of the beam buckles at four times the load; its ends stand free."""
    half = lf.Stiffening(axial_force=-20.0, between=("center", "right"))
    assert unit_beam().reduce(4, stiffening=half).frequencies()[0] > 1.0
    with pytest.raises(ModelError, match="buckles"):
        unit_beam().reduce(4, stiffening=replace(half, between=("left", "right")))
    turned = replace(half, between=("right", "center"))
    np.testing.assert_array_equal(
        unit_beam().reduce(4, stiffening=half).stiffness, unit_beam().reduce(4, stiffening=turned).stiffness
    )


def test_prestressed_frequencies_are_those_of_the_plane() -> None:
    flat = lf.Beam(1.0, 1e-4, 1e-4, 1e8, 12e16, 12, axial=False)
    beam = lf.SpatialBeam(1.0, 1e-8, (1e-16 / 12, 1e-16 / 12), 1e-17, 1e8, 12e16, 0.3, shear_factor=None, elements=12)
    for force, ends in ((-8.0, ("left", "right")), (300.0, ("left", "right")), (40.0, ("center", "right"))):
        stiffening = lf.Stiffening(axial_force=force, between=ends)
        found = beam.reduce(6, stiffening=stiffening).frequencies()
        expected = flat.reduce(3, stiffening=stiffening).frequencies()
        np.testing.assert_allclose(found.reshape(3, 2), np.tile(expected[:, None], 2), rtol=1e-6)


def second_order(body: SpatialBody, eta: FloatArray, p: float, elements: int) -> FloatArray:
    """J that s2 adds, by sums over the beam: foreshortening from p, and sections that turn as rigid ones."""
    y, z = math.sqrt(INERTIA / AREA), math.sqrt(2.0 * INERTIA / AREA)
    corners = [np.array([0.0, a * y, b * z]) for a in (-1, 1) for b in (-1, 1)]
    place, weight = np.polynomial.legendre.leggauss(6)

    def moved(x: float) -> tuple[FloatArray, FloatArray]:
        point = body.locate(x, 0.0, 0.0)
        return point.phi.T @ eta, point.psi.T @ eta

    def gauss(a: float, b: float) -> list[tuple[float, float]]:
        breaks = np.unique([a, b, *[x for x in np.linspace(-0.5, 0.5, elements + 1) if a < x < b]])
        return [
            (float(0.5 * (c + d + (d - c) * t)), float(0.5 * (d - c) * w))
            for c, d in itertools.pairwise(breaks)
            for t, w in zip(place, weight, strict=True)
        ]

    def shortening(x: float) -> float:
        h = 1e-5 / elements  # inside of an element, whose fields are cubic: five places are exact
        parts = {1: 8.0 / 12.0, -1: -8.0 / 12.0, 2: -1.0 / 12.0, -2: 1.0 / 12.0}
        slope = sum(w * moved(x + j * h)[0] for j, w in parts.items()) / h
        twist = sum(w * moved(x + j * h)[1][0] for j, w in parts.items()) / h
        return float(slope[1] ** 2 + slope[2] ** 2 + POLAR / AREA * twist**2)

    J = np.zeros((3, 3))
    for x, w in gauss(-0.5, 0.5):
        a, b = sorted((p, x))
        drawn = -0.5 * math.copysign(1.0, x - p) * sum(v * shortening(t) for t, v in gauss(a, b))
        theta = moved(x)[1]
        for corner in corners:
            s = np.array([x - p, 0.0, 0.0]) + corner
            s2 = np.array([drawn, 0.0, 0.0]) + 0.5 * np.cross(theta, np.cross(theta, corner))
            P = 0.25 * w * (np.outer(s, s2) + np.outer(s2, s))
            J += np.trace(P) * np.eye(3) - P
    return J


@pytest.mark.filterwarnings("ignore:stiffening")  # many modes in a clamped frame
@pytest.mark.parametrize(
    ("held", "clamped", "p", "shear"),
    [
        (None, None, 0.0, None),
        ("left", None, -0.5, (0.8, 0.3)),
        ((0.13, 0.0, 0.0), None, 0.13, None),
        (None, "right", 0.5, 0.5),
    ],
)
def test_inertia_is_that_of_displacements_of_second_order(held: Any, clamped: str | None, p: float, shear: Any) -> None:
    elements = 3
    body = unit_beam(elements, shear).reduce(
        None, clamped=clamped, stiffening=lf.Stiffening(held=held), second_order=18
    )
    eta = np.random.default_rng(2).normal(size=body.modes) / np.sqrt(body.stiffness)
    assert body.geometric is not None
    expected = -second_order(body, eta, p, elements)
    found = np.einsum("ikl,k,l->i", body.geometric, eta, eta)
    scale = np.abs(expected).max()
    six = [expected[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))]
    np.testing.assert_allclose(found, six, rtol=0, atol=1e-8 * scale)
    assert min(map(abs, six)) > 1e-6 * scale


def test_bending_is_that_of_the_plane() -> None:
    """G_zz of bending in xy, and G_yy of bending in xz, of modes that are the same."""
    flat = lf.Beam(1.0, 1e-4, 1e-4, 1e8, 12e16, 12, axial=False)
    moments = (2e-16 / 12, 1e-16 / 12)
    beam = lf.SpatialBeam(1.0, 1e-8, moments, 1e-17, 1e8, 12e16, 0.3, shear_factor=None, elements=12)
    for held in (None, "left", "center"):
        body = beam.reduce(6, stiffening=lf.Stiffening(held=held))
        planar = flat.reduce(3, stiffening=lf.Stiffening(held=held)).geometric
        assert body.geometric is not None
        assert planar is not None
        tip = body.points["right"].phi
        for axis, across in ((2, 1), (1, 2)):
            own = np.flatnonzero(np.abs(tip[:, across]) > 1.0)
            signs = np.sign(tip[own, across])
            # both have tips up here: signs of modes are free
            flat_signs = np.sign([flat.reduce(3).locate(1.0, 0.0).phi[k, 1] for k in range(3)])
            found = body.geometric[axis][np.ix_(own, own)] * np.outer(signs, signs)
            np.testing.assert_allclose(found, planar * np.outer(flat_signs, flat_signs), rtol=1e-6, atol=1e-6)
        assert np.abs(body.geometric[0]).max() < 1e-6


def test_what_else_is_asked_for() -> None:
    stiffening = lf.Stiffening(held="left", axial_force=3.0)
    body = unit_beam().reduce(4, interfaces=["left"], stiffening=stiffening)
    assert body.reduction is not None
    again = body.reduction.make(6)
    assert again.geometric is not None
    np.testing.assert_allclose(again.stiffness[:3], body.stiffness[:3], rtol=1e-9)
    np.testing.assert_allclose(np.diag(again.geometric[2])[:3], np.diag(body.geometric[2])[:3], rtol=1e-6)  # type: ignore[index]
    assert unit_beam().reduce(0, stiffening=stiffening).geometric is None
    assert unit_beam().reduce(4).geometric is None
    named, placed = (unit_beam().reduce(4, stiffening=lf.Stiffening(held=held)) for held in ("left", (-0.5, 0.0, 0.0)))
    np.testing.assert_array_equal(named.geometric, placed.geometric)
    with pytest.warns(ModelWarning, match="stiffening: it, and 8 modes in a clamped frame .* expected fewer modes"):
        unit_beam().reduce(8, clamped="left", stiffening=lf.Stiffening())


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: unit_beam().reduce(4, stiffening=3.0), "stiffening: 3.0 was given, expected a Stiffening"),
        (
            lambda: unit_beam().reduce(4, stiffening=lf.Stiffening(axial_force="actual")),
            "'actual' was given for a Spat",
        ),
        (
            lambda: unit_beam().reduce(4, stiffening=lf.Stiffening(axial_force=1e20)),
            r"axial_force: 1e\+20 .* E A = 30000",
        ),
        (lambda: unit_beam().reduce(4, stiffening=lf.Stiffening(axial_force=-1e300)), "axial_force: -1e.300 .* E A"),
        (lambda: unit_beam().reduce(4, stiffening=lf.Stiffening(held="tip")), "held: 'tip' was given, expected the na"),
        (lambda: unit_beam().reduce(4, stiffening=lf.Stiffening(held=(0.1, 0.0))), r"expected \(x, y, z\) of space"),
        (lambda: unit_beam().reduce(4, stiffening=lf.Stiffening(held=(0.6, 0, 0))), "held: x"),
        (lambda: unit_beam().reduce(4, stiffening=lf.Stiffening(held=(0.1, 0.1, 0))), "expected a place on the axis"),
        (lambda: unit_beam().reduce(4, stiffening=lf.Stiffening(between=("left", "top"))), "between: 'top' was given"),
        (lambda: lf.Stiffening(held=(1.0, 2.0, 3.0, 4.0)), "held: .* expected a place"),
        (lambda: lf.Stiffening(held=(1.0, math.nan, 3.0)), "held"),
        (
            lambda: lf.Beam(1.0, 0.1, 0.1, 1.0, 1.0).reduce(3, stiffening=lf.Stiffening(held=(0.1, 0.0, 0.0))),
            r"expected \(x, y\) of the plane",
        ),
        (
            lambda: lf.bodies.Continuum(meshes.bar(1.0, 0.1, 4), 1.0, 1.0, 0.0, thickness=0.1).reduce(
                3, stiffening=lf.Stiffening(held=(0.1, 0.0, 0.0))
            ),
            "held",
        ),
        (lambda: replace(stiff(), geometric=np.ones((6, 3, 3))), r"geometric: .*expected shape \(6, 4, 4\)"),
        (lambda: replace(stiff(), geometric=np.arange(96.0).reshape(6, 4, 4)), "geometric: .* not symmetric"),
    ],
)
def test_refused(make: Callable[[], Any], match: str) -> None:
    with pytest.raises(ModelError, match=match):
        make()


def stiff() -> SpatialBody:
    return unit_beam().reduce(4, stiffening=lf.Stiffening())


def test_scene_refuses_a_start_that_is_bent_too_far() -> None:
    scene = lf.SpatialScene(gravity=(0, 0, 0))
    scene.add(stiff(), modal=[2.0, 0.0, 0.0, 0.0])
    with pytest.raises(ModelError, match="bent too far for its stiffening by spin"):
        scene.compile()
