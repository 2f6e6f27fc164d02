"""Rigid bodies of space: inertia integrals of shapes against quadrature, and what no mass can have."""

from __future__ import annotations

import copy
import math
import pickle
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.compile.spatial.bodies import compile_spatial_bodies

INERTIA = np.diag([0.2, 0.3, 0.4])
RNG = np.random.default_rng(5)
CLOUD = RNG.uniform(-1.0, 1.0, (30, 3)) * [0.3, 0.2, 0.5] + [7.0, -3.0, 2.0]


def of_revolution(radius, ends):
    """Volume and second moments (xx, zz) of a solid of revolution about z, by Gauss points between ``ends``."""
    x, w = np.polynomial.legendre.leggauss(12)
    total = np.zeros(3)
    for low, high in pairwise(ends):
        z, weight = 0.5 * (low + high) + 0.5 * (high - low) * x, 0.5 * (high - low) * w
        r2 = np.array([radius(float(at)) ** 2 for at in z])
        total += [np.pi * (weight @ r2), np.pi * (weight @ r2**2) / 4.0, np.pi * (weight @ (r2 * z * z))]
    return total


@pytest.mark.parametrize(
    ("body", "radius", "ends"),
    [
        (lf.Sphere(0.3, density=2.0), lambda z: math.sqrt(0.09 - z * z), (-0.3, 0.0, 0.3)),
        (lf.Cylinder(0.3, 0.8, density=2.0), lambda z: 0.3, (-0.4, 0.4)),
        (
            lf.Capsule(0.3, 0.8, density=2.0),
            lambda z: math.sqrt(0.09 - max(abs(z) - 0.4, 0.0) ** 2),
            (-0.7, -0.4, 0.4, 0.7),
        ),
    ],
)
def test_round_bodies_have_the_integrals_of_their_slices(body, radius, ends):
    volume, across, along = of_revolution(radius, ends)
    assert body.mass == pytest.approx(2.0 * volume, rel=1e-13)
    assert body.second == pytest.approx(2.0 * np.diag([across, across, along]), rel=1e-13, abs=1e-16)
    assert body.inertia == pytest.approx(2.0 * np.diag([across + along, across + along, 2.0 * across]), rel=1e-13)
    assert not body.moment.any()


def test_shapes_take_a_mass_in_place_of_a_density():
    for make in (lf.Sphere, lambda *a, **k: lf.Capsule(*a, 0.2, **k), lambda *a, **k: lf.Cuboid(*a, 0.2, 0.3, **k)):
        heavy = make(0.1, density=7800.0)
        assert make(0.1, mass=heavy.mass).second == pytest.approx(heavy.second, rel=1e-14)


def test_cuboid_and_the_hull_of_its_corners_are_one_body():
    box = lf.Cuboid(0.3, 0.5, 0.2, density=1000.0)
    assert box.mass == pytest.approx(30.0, rel=1e-15)
    assert box.inertia == pytest.approx(30.0 / 12.0 * np.diag([0.25 + 0.04, 0.09 + 0.04, 0.09 + 0.25]), rel=1e-15)
    assert box.points["right_back_top"].place == pytest.approx([0.15, 0.25, 0.1])
    turn = Rotation.from_rotvec([0.3, -0.8, 0.4]).as_matrix()
    at = np.array([10.0, -20.0, 3.0])
    hull = lf.ConvexHull(box.shape.vertices @ turn.T + at, density=1000.0)
    assert hull.mass == pytest.approx(box.mass, rel=1e-12)
    assert hull.origin == pytest.approx(at, rel=1e-14)
    assert hull.second == pytest.approx(turn @ box.second @ turn.T, rel=1e-11)
    assert hull.moment.tolist() == [0.0, 0.0, 0.0]


def test_a_hull_has_the_integrals_of_the_tetrahedra_inside_of_it():
    body = lf.ConvexHull(CLOUD, density=3.0)
    cells = Delaunay(CLOUD, qhull_options="Qbb Qc Qz Qt").simplices
    corners = CLOUD[cells] - body.origin
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6.0
    a, b = (5.0 - math.sqrt(5.0)) / 20.0, (5.0 + 3.0 * math.sqrt(5.0)) / 20.0  # exact for squares
    places = np.einsum("gk,tki->tgi", np.full((4, 4), a) + (b - a) * np.eye(4), corners)
    assert body.mass == pytest.approx(3.0 * volume.sum(), rel=1e-12)
    assert np.abs(np.einsum("t,tgi->i", volume, places)).max() < 1e-13
    assert body.second == pytest.approx(0.75 * np.einsum("t,tgi,tgj->ij", volume, places, places), rel=1e-11)
    names = [name for name in body.points if name != "center"]
    for name in names:
        assert body.points[name].place == pytest.approx(CLOUD[int(name.removeprefix("vertex_"))] - body.origin)
    assert len(names) < len(CLOUD)


def test_triangles_of_surfaces_enclose_their_volume():
    for body in (lf.Cuboid(0.3, 0.5, 0.2, density=1.0), lf.ConvexHull(CLOUD, density=1.0)):
        corners = body.shape.vertices[body.shape.triangles]
        assert np.linalg.det(corners).sum() / 6.0 == pytest.approx(body.mass, rel=1e-12)
        assert (np.linalg.det(corners) > 0.0).all()  # counter-clockwise from outside, about the centre


def test_given_inertia_is_moved_and_turned():
    turn = Rotation.from_rotvec([0.3, -0.8, 0.4])
    body = lf.SpatialRigidBody(2.0, (0.2, 0.3, 0.4), center=(1.0, 2.0, -1.0), points={"tip": (0, 0, 1)}, axes=turn)
    R = turn.as_matrix()
    assert body.central_inertia == pytest.approx(R @ INERTIA @ R.T, rel=1e-13)
    steiner = 2.0 * (6.0 * np.eye(3) - np.outer([1, 2, -1], [1, 2, -1]))
    assert body.inertia == pytest.approx(R @ INERTIA @ R.T + steiner, rel=1e-13)
    assert body.centre == pytest.approx([1.0, 2.0, -1.0])
    assert body.points["tip"].phi.shape == (0, 3)
    assert body.modes == 0
    assert body.frequencies().shape == (0,)
    matrix = lf.SpatialRigidBody(2.0, R @ INERTIA @ R.T, center=(1.0, 2.0, -1.0))
    assert matrix.second == pytest.approx(body.second, rel=1e-13)


def test_inertia_and_second_moments_say_the_same():
    body = lf.SpatialBody(mass=1.0, inertia=INERTIA)
    assert body.second == pytest.approx(np.diag([0.25, 0.15, 0.05]))
    again = lf.SpatialBody(mass=1.0, second=body.second, inertia=INERTIA)
    assert again.inertia == pytest.approx(INERTIA)
    for other in (copy.copy(body), pickle.loads(pickle.dumps(lf.Sphere(1.0, mass=1.0)))):
        assert not other.second.flags.writeable
    with pytest.raises(lf.ModelError, match="both were given and differ"):
        lf.SpatialBody(mass=1.0, second=body.second, inertia=2.0 * INERTIA)
    with pytest.raises(lf.ModelError, match="neither was given"):
        lf.SpatialBody(mass=1.0)


def test_thin_bodies_with_an_inertia_about_every_axis_are_bodies():
    plate = lf.SpatialRigidBody(1.0, (0.1, 0.2, 0.3))
    assert np.linalg.eigvalsh(plate.second)[0] == pytest.approx(0.0, abs=1e-15)
    printed = lf.SpatialRigidBody(1.0, (0.1234565, 0.2345676, 0.3580242))  # rounded by 1e-7: no alarm
    assert printed.inertia[2, 2] == pytest.approx(0.3580242)
    assert lf.Cylinder(1e-4, 1.0, mass=1.0).inertia[2, 2] == pytest.approx(5e-9)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: lf.SpatialRigidBody(1.0, (1.0, 1.0, 2.1)), "at most the sum of the two others"),
        (lambda: lf.SpatialRigidBody(1.0, (1.0, 1.0, -1.0)), "at most the sum of the two others"),
        (lambda: lf.SpatialRigidBody(1.0, (1.0, 1.0, 0.0)), "line that the mass lies on"),
        (lambda: lf.SpatialRigidBody(1.0, (0.0, 0.0, 0.0)), "point mass"),
        (lambda: lf.SpatialRigidBody(1.0, (0.0, 0.0, 0.0), center=(1, 0, 0)), "point mass"),
        (lambda: lf.Cylinder(1e-7, 1.0, mass=1.0), "line that the mass lies on"),
        (lambda: lf.SpatialRigidBody(1.0, [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]), "inertia: the matrix is unsymmetric"),
        (lambda: lf.SpatialRigidBody(1.0, np.full((3, 3), math.nan)), "inertia: an array with nan"),
        (lambda: lf.SpatialRigidBody(-1.0, INERTIA), "mass: -1.0 was given"),
        (lambda: lf.SpatialRigidBody(1.0, INERTIA, axes=np.diag([1, 1, -1])), "axes: .* left-handed"),
        (lambda: lf.SpatialRigidBody(1.0, INERTIA, axes=np.diag([1, 1, 1.001])), "axes: .* off orthonormal ones"),
        (lambda: lf.SpatialRigidBody(1.0, INERTIA, axes=(1, 0, 0, 0)), r"axes: .* expected shape \(3, 3\)"),
        (lambda: lf.SpatialRigidBody(1.0, INERTIA, center=(1, 2)), r"center: .* expected shape \(3\)"),
        (lambda: lf.SpatialRigidBody(1.0, INERTIA, points={"a": (1, 2)}), r"points\['a'\]: .*expected shape"),
        (lambda: lf.Sphere(0.0, mass=1.0), "radius: 0.0 was given"),
        (lambda: lf.Sphere(1.0), "density, mass: None and None"),
        (lambda: lf.Sphere(1.0, mass=1.0, density=1.0), "density, mass: 1.0 and 1.0"),
        (lambda: lf.Cuboid(1.0, -1.0, 1.0, mass=1.0), "b: -1.0 was given"),
        (lambda: lf.Capsule(1.0, math.inf, mass=1.0), "length: inf was given"),
        (lambda: lf.ConvexHull(np.eye(3), mass=1.0), "points: 3 were given"),
        (lambda: lf.ConvexHull(CLOUD * [1, 1, 0], mass=1.0), "points: they lie in one plane"),
        (lambda: lf.ConvexHull(np.ones((5, 3)), mass=1.0), "points: they lie in one plane"),
        (lambda: lf.ConvexHull(CLOUD[:, :2], mass=1.0), "points: an array of shape"),
        (lambda: lf.Sphere(1.0, mass=1.0).point("tip"), "there is no point 'tip'"),
        (lambda: lf.Sphere(1.0, mass=1.0).at_nodes(3), "nodes: this body has no mesh"),
        (lambda: lf.SpatialBody(mass=1.0, inertia=INERTIA, points={"a": (0, 0, 0)}), "expected a SpatialPoint"),
    ],
)
def test_what_cannot_be_is_refused(make, words):
    with pytest.raises(lf.ModelError, match=words):
        make()


def one_mode(**changed):
    """The arguments of a body with one mode, an even motion of its halves along x."""
    products = np.zeros((1, 1, 9))
    products[0, 0, 0] = 1.0
    return {"mass": 1.0, "inertia": INERTIA, "stiffness": [100.0], "products": products, **changed}


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"products": np.zeros((1, 1, 9))}, "products: .* misses 1 and 0 by 1"),
        ({"products": np.zeros((2, 2, 9))}, "products: .* n2 <= 1"),
        ({"stiffness": [0.0]}, "expected elastic modes only"),
        ({"damping": [-1.0]}, "expected elastic modes only"),
        ({"damping": [1.0, 2.0]}, "damping: an array of shape"),
        ({"S": [[2.0, 0.0, 0.0]]}, "S, first: the modes carry more mass"),
        ({"first": [[0, 1, 0, -1, 0, 0, 0, 0, 0]]}, "S, first: the modes carry more mass"),
        ({"cross_damping": [[1.0]]}, "its diagonal belongs into damping"),
        ({"residual_modes": 2}, "residual_modes: 2 was given"),
    ],
)
def test_modes_that_cannot_be_are_refused(changed, words):
    with pytest.raises(lf.ModelError, match=words):
        lf.SpatialBody(**one_mode(**changed))


def test_a_written_flexible_body_knows_its_named_points_alone():
    point = lf.SpatialPoint(np.zeros(3), np.ones((1, 3)), np.zeros((1, 3)))
    body = lf.SpatialBody(**one_mode(points={"a": point}))
    assert body.point("a") is point
    assert body.second_order_modes == 1
    with pytest.raises(lf.ModelError, match="named points alone"):
        body.locate(0.0, 0.0, 0.0)


def test_bodies_are_compiled_one_after_the_other():
    first = np.arange(9.0)[None] * 1e-3
    mean = first.reshape(3, 3) + first.reshape(3, 3).T + 1e-16 * first.reshape(3, 3)
    free = lf.SpatialBody(**one_mode(first=mean.reshape(1, 9), moment=[1e-16, 0, 0], S=[[0, 1e-15, 0]]))
    held = lf.SpatialBody(**one_mode(S=[[0.5, 0, 0]], damping=[0.3]))
    off = lf.SpatialRigidBody(1.0, INERTIA, center=(0.1, 0, 0))
    arrays = compile_spatial_bodies([free, lf.Sphere(1.0, mass=2.0), held, off])
    assert arrays.dof.tolist() == [0, 7, 13, 20, 26]
    assert arrays.place.tolist() == [0, 8, 15, 23, 30]
    assert arrays.centred.tolist() == [1, 1, 0, 0]
    assert arrays.moment.tolist() == [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0.1, 0, 0]]
    assert arrays.S.tolist() == [[0, 0, 0], [0.5, 0, 0]]
    kept = arrays.first[0].reshape(3, 3)
    assert np.array_equal(kept, kept.T)
    assert kept == pytest.approx(mean)
    assert arrays.damping.tolist() == [0.0, 0.3]
    assert arrays.second_modes.tolist() == [1, 0, 1, 0]
    assert arrays.products_start.tolist() == [0, 9, 9, 18, 18]
    assert arrays.cross_damping_start.tolist() == [0, 0, 0, 0, 0]
    assert arrays.second.shape == (4, 3, 3)
    empty = compile_spatial_bodies([])
    assert (empty.dof.tolist(), empty.first.shape, empty.second.shape) == ([0], (0, 9), (0, 3, 3))
