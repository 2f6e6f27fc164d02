"""Bodies of space from matrices of solid elements: integrals, frames, reductions, points, and what is refused."""

from __future__ import annotations

import math
import pickle
from functools import cache

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse

import lcpflex as lf
from lcpflex.bodies.spatial.nodes import NodePoints
from lcpflex.compile.spatial.bodies import compile_spatial_bodies
from tests.solids import bar, block
from tests.spatial_inertia import mass_matrix, stretch_by_spin, velocity_columns

EDGES = (0.3, 0.2, 0.1)
HZ = 2.0 * math.pi


@cache
def made(kind="hex2", cells=(3, 2, 1), shear=0.0):
    return block(EDGES, cells, kind, skew=shear)


def sets():
    x, y, z = made()["coordinates"].T
    return {
        "left": np.flatnonzero(x < 1e-9),
        "right": np.flatnonzero(x > 0.3 - 1e-9),
        "edge": np.flatnonzero((x < 1e-9) & (y < 1e-9)),
        "corner": np.flatnonzero((x < 1e-9) & (y < 1e-9) & (z < 1e-9)),
    }


@cache
def solid():
    return lf.SpatialMatrices(**made(), node_sets=sets())


def nodal_mass(body, matrices, eta):
    """L^T M_FE L with the velocities L of all nodes."""
    L = velocity_columns(matrices["coordinates"] - body.origin, body.shape.phi, eta)
    return L.T @ (matrices["mass"] @ L)


@pytest.mark.parametrize("kind", ["hex1", "hex2", "tet1", "tet2"])
def test_mass_and_inertia_of_a_block_are_exact_to_rounding(kind):
    sheared = np.array([[1.0, 0.0, 0.4], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    body = lf.SpatialMatrices(**made(kind, shear=0.4)).reduce(0)
    m = 7850.0 * math.prod(EDGES)
    assert body.mass == pytest.approx(m, rel=1e-13)
    assert body.origin == pytest.approx(sheared @ EDGES / 2.0, rel=1e-13)
    assert body.second == pytest.approx(m / 12.0 * sheared @ np.diag(np.square(EDGES)) @ sheared.T, rel=1e-12)
    assert not body.moment.any()


def test_lumped_masses_are_not_what_the_integrals_come_from():
    given = block((0.6, 0.3, 0.2), (6, 3, 2), "hex1")
    exact = given["mass"].sum() / 3.0 * (0.3**2 + 0.2**2) / 12.0
    too_large = (0.3**2 * (1.0 + 2.0 / 3**2) + 0.2**2 * (1.0 + 2.0 / 2**2)) / (0.3**2 + 0.2**2)  # 1.308
    assert lf.SpatialMatrices(**given).reduce(0).inertia[0, 0] == pytest.approx(exact, rel=1e-13)
    lumped = given | {"mass": scipy.sparse.diags_array(np.asarray(given["mass"].sum(axis=1)).ravel()).tocsc()}
    with pytest.warns(lf.ModelWarning, match="mass: a diagonal matrix was given"):
        found = lf.SpatialMatrices(**lumped).reduce(0).inertia[0, 0]
    assert found / exact == pytest.approx(too_large, rel=1e-12)


@pytest.mark.parametrize("kind", ["hex1", "hex2", "tet1", "tet2"])
@pytest.mark.parametrize("clamped", [False, True])
def test_the_mass_matrix_of_a_deformed_body_is_that_of_its_nodes(kind, clamped):
    given = made(kind, shear=0.4)
    held = np.flatnonzero(given["coordinates"][:, 2] < 1e-9) if clamped else None
    body = lf.SpatialMatrices(**given).reduce(6, clamped=held)
    eta = 0.02 * np.random.default_rng(3).standard_normal(6) * math.sqrt(body.mass)
    expected = nodal_mass(body, given, eta)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((mass_matrix(body, eta) - expected) / scale).max() < 1e-11
    assert compile_spatial_bodies([body]).centred.tolist() == [int(not clamped)]
    if clamped:
        assert np.abs(body.S).max() > 0.1 * math.sqrt(body.mass)
        assert not body.origin.any()


def test_products_are_kept_of_as_many_modes_as_are_asked_for():
    assert solid().reduce(15).second_order_modes == 12
    assert solid().reduce(5).second_order_modes == 5
    few = solid().reduce(5, second_order=2)
    assert few.products == pytest.approx(solid().reduce(5).products[:2, :2], abs=1e-12)
    with pytest.raises(lf.ModelError, match="second_order: 6 was given"):
        solid().reduce(5, second_order=6)


def test_frequencies_of_the_steel_bar():
    """Exact Timoshenko bending and Love's longitudinal wave, one element across: 0.27 % and less."""
    hertz = lf.SpatialMatrices(**bar((10, 1, 1))).reduce(8).frequencies() / HZ
    assert hertz[0] / 2568.2 - 1.0 == pytest.approx(2.7e-3, rel=0.05)
    assert hertz[7] == pytest.approx(12920.9, rel=1e-4)


def test_a_spinning_bar_is_stretched():
    """As the nodes of the mesh are by their own centrifugal forces; about rho omega^2 (L/2)^3 / (3 E)."""
    given = bar((10, 1, 1))
    body = lf.SpatialMatrices(**given).reduce(None, second_order=0)
    places, spin = given["coordinates"] - [0.1, 0.0, 0.0], np.array([300.0, 0.0, 2000.0])
    away = np.cross(np.cross(spin, places), spin).ravel()
    static = np.linalg.lstsq(given["stiffness"].toarray(), given["mass"] @ away, rcond=1e-13)[0].reshape(-1, 3)
    end = int(np.linalg.norm(places - [0.1, 0.0, 0.0], axis=1).argmin())
    middle = int(np.linalg.norm(places, axis=1).argmin())
    found = stretch_by_spin(body, spin, 0.1)
    assert found == pytest.approx(static[end, 0] - static[middle, 0], rel=1e-7)
    assert found == pytest.approx(4.98413e-5, rel=1e-3)


@pytest.mark.slow
def test_frequencies_of_the_steel_bar_meshed_more_finely():
    """The same, with two elements across."""
    body = lf.SpatialMatrices(**bar((20, 2, 2))).reduce(8)
    hertz = body.frequencies() / HZ
    assert hertz[:2] == pytest.approx([2568.2, 2568.2], rel=6e-4)
    assert hertz[2:4] == pytest.approx([6684.7, 6684.7], rel=2e-3)
    assert hertz[4] == pytest.approx(7364.8, rel=2e-2)  # torsion: the section warps in quadratic elements
    assert hertz[7] == pytest.approx(12920.9, rel=1e-4)


def test_free_modes_are_those_of_the_matrices():
    given = made()
    values = scipy.linalg.eigh(given["stiffness"].toarray(), given["mass"].toarray(), eigvals_only=True)[6:16]
    assert solid().reduce(10).stiffness == pytest.approx(values, rel=1e-9)
    every = lf.SpatialMatrices(**made("hex1", (1, 1, 1))).reduce(None)
    assert every.modes == 18


def compliance(body, names):
    """(6 k, 6 k) of unit forces and moments at points, balanced by inertia: that of the elastic modes."""
    B = np.hstack([np.hstack([body.points[name].phi, body.points[name].psi]) for name in names])
    return B.T @ (B / body.stiffness[:, None])


def test_residual_modes_have_the_compliance_of_the_mesh():
    whole = compliance(solid().reduce(None), ["left", "right"])
    few = solid().reduce(4, interfaces=["left", "right"])
    assert few.residual_modes == 12
    assert few.modes == 16
    scale = np.sqrt(np.outer(np.diag(whole), np.diag(whole)))
    assert np.abs((compliance(few, ["left", "right"]) - whole) / scale).max() < 1e-9
    without = compliance(solid().reduce(16), ["left", "right"])
    assert np.abs((without - whole) / scale).max() > 0.01
    assert few.stiffness[:4] == pytest.approx(solid().reduce(4).stiffness, rel=1e-9)
    assert compile_spatial_bodies([few]).centred.tolist() == [1]


def test_numbered_nodes_and_lines_add_forces_alone():
    assert solid().reduce(4, interfaces=[5]).residual_modes == 3
    assert solid().reduce(4, interfaces=["edge"]).residual_modes == 3
    assert solid().reduce(4, interfaces=["corner"]).residual_modes == 6
    assert solid().reduce(4, interfaces=[[0, 1, 7]]).residual_modes == 6


def test_craig_bampton_keeps_the_boundary():
    body = solid().reduce(60, boundary=["corner", "right"])
    n = 3 * (1 + len(sets()["right"]))
    assert body.modes == n + 60 - 6
    exact = solid().reduce(6).stiffness
    assert (body.stiffness[:6] >= exact * (1.0 - 1e-10)).all()
    assert body.stiffness[:6] == pytest.approx(exact, rel=0.01)
    # a self-equilibrated load on the boundary: exact statically
    nodes = sets()["right"][[0, -1]]
    places = made()["coordinates"][nodes]
    along = (places[1] - places[0]) / np.linalg.norm(places[1] - places[0])
    whole = solid().reduce(None)

    def stretch(of):
        B = (of.shape.phi[nodes[1]] - of.shape.phi[nodes[0]]) @ along
        return B @ (B / of.stiffness)

    assert stretch(body) == pytest.approx(stretch(whole), rel=1e-8)


def test_clamped_modes_are_those_of_the_held_mesh():
    given, held = made(), sets()["left"]
    inner = np.setdiff1d(np.arange(given["mass"].shape[0]), (3 * held[:, None] + np.arange(3)).ravel())
    M, K = (given[name][inner][:, inner].toarray() for name in ("mass", "stiffness"))
    body = solid().reduce(6, clamped="left")
    assert body.stiffness == pytest.approx(scipy.linalg.eigh(K, M, eigvals_only=True)[:6], rel=1e-9)
    assert np.abs(body.shape.phi[held]).max() == 0.0
    assert body.centre == pytest.approx([0.15, 0.1, 0.05])
    # static response to a force on the far face, as in the matrices
    load = np.zeros(given["mass"].shape[0])
    load[3 * sets()["right"] + 2] = 1.0 / len(sets()["right"])
    sag = load[inner] @ np.linalg.solve(K, load[inner])
    few = solid().reduce(3, clamped="left", interfaces=["right"])
    z = few.points["right"].phi[:, 2]
    assert z @ (z / few.stiffness) == pytest.approx(sag, rel=1e-9)
    assert np.abs(few.points["left"].phi).max() == 0.0
    both = solid().reduce(3, clamped="left", boundary="right")
    z = both.points["right"].phi[:, 2]
    assert z @ (z / both.stiffness) == pytest.approx(sag, rel=1e-8)


def test_a_given_basis_is_taken_without_its_rigid_motions():
    whole = solid().reduce(5)
    shapes = whole.shape.phi.transpose(0, 2, 1).reshape(-1, 5)
    places = made()["coordinates"]
    turn = np.cross([0.3, 0.1, -0.2], places).ravel()
    mixed = shapes @ np.triu(np.ones((5, 5))) + np.outer(turn, [1, 2, 3, 4, 5])
    body = solid().reduce(basis=np.column_stack([mixed, turn]))
    assert body.stiffness == pytest.approx(whole.stiffness, rel=1e-9)
    assert compile_spatial_bodies([body]).centred.tolist() == [1]
    with pytest.raises(lf.ModelError, match="basis: nothing elastic"):
        solid().reduce(basis=turn[:, None])
    with pytest.raises(lf.ModelError, match="basis: it moves what is clamped"):
        solid().reduce(basis=shapes, clamped="left")
    cantilever = solid().reduce(4, clamped="left")
    held = cantilever.shape.phi.transpose(0, 2, 1).reshape(-1, 4)
    assert solid().reduce(basis=held, clamped="left").stiffness == pytest.approx(cantilever.stiffness, rel=1e-9)


def test_points_turn_as_rigid_bodies_and_fields_do():
    places, names = made()["coordinates"], sets()
    points = NodePoints(lf.SpatialMatrices(**made()).finite_elements())
    t, w = np.array([0.3, -0.2, 0.5]), np.array([0.1, 0.7, -0.4])
    rigid = (t + np.cross(w, places)).ravel()
    strain = np.array([[1.0, 0.3, 0.2], [0.3, -0.5, 0.7], [0.2, 0.7, 2.0]])
    for name, weights in (("left", None), ("right", np.linspace(1, 2, len(names["right"]))), ("corner", None)):
        at = points.of_nodes(names[name], weights)
        assert at.u.T @ rigid[at.rows] == pytest.approx(t + np.cross(w, at.place), abs=1e-13)
        assert at.psi.T @ rigid[at.rows] == pytest.approx(w, abs=1e-12)
        assert at.turns
    corner = points.of_nodes(names["corner"])
    assert corner.psi.T @ (places @ strain).ravel()[corner.rows] == pytest.approx(np.zeros(3), abs=1e-12)
    edge = points.of_nodes(names["edge"])
    assert not edge.turns
    assert not edge.psi.any()
    assert edge.u.T @ rigid[edge.rows] == pytest.approx(t + np.cross(w, edge.place), abs=1e-13)


def test_points_of_bodies_are_found_by_name_node_and_place():
    body = solid().reduce(4)
    corner = int(sets()["corner"][0])
    named = body.point("corner")
    for other in (body.at_nodes(corner), body.locate(*(-body.origin))):
        assert other.place == pytest.approx(named.place)
        assert other.phi == pytest.approx(named.phi)
        assert other.psi == pytest.approx(named.psi)
    assert named.phi == pytest.approx(body.shape.phi[corner])
    face = body.at_nodes(sets()["left"])
    assert face.place == pytest.approx([-0.15, 0.0, 0.0], abs=1e-15)
    assert face.phi == pytest.approx(body.shape.phi[sets()["left"]].mean(axis=0))
    with pytest.raises(lf.ModelError, match="no node lies there; the nearest one"):
        body.locate(0.01, 0.02, 0.03)
    with pytest.raises(lf.ModelError, match="nodes: one appears twice"):
        body.at_nodes([3, 3])
    with pytest.raises(lf.ModelError, match="weights: -1 was given"):
        body.at_nodes([3, 4], [1, -1])
    again = pickle.loads(pickle.dumps(body))
    assert again.point("corner").phi == pytest.approx(named.phi)


def test_damping_is_modal_or_that_of_the_matrix():
    body = solid().reduce(3, damping=[0.01, 0.02, 0.03], interfaces=["right"])
    zeta = body.damping / (2.0 * body.frequencies())
    assert zeta == pytest.approx([0.01, 0.02, *[0.03] * 7])
    given = made()
    damped = lf.SpatialMatrices(**given, damping=3.0 * given["mass"] + 1e-6 * given["stiffness"]).reduce(4)
    assert damped.damping == pytest.approx(3.0 + 1e-6 * damped.stiffness, rel=1e-9)
    assert damped.cross_damping is None
    local = 1e3 * scipy.sparse.diags_array((np.arange(given["mass"].shape[0]) < 30).astype(float)).tocsc()
    assert lf.SpatialMatrices(**given, damping=local).reduce(4).cross_damping is not None


def changed(**parts):
    return lf.SpatialMatrices(**{**made("hex1"), **parts})


def of(name, row, column, value):
    matrix = made("hex1")[name].tolil(copy=True)
    matrix[row, column] += value
    return {name: matrix.tocsc()}


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: changed(coordinates=made("hex1")["coordinates"][:, :2]), "coordinates: .* expected shape"),
        (lambda: changed(coordinates=made("hex1")["coordinates"][:-1]), "mass: .* three rows a node"),
        (lambda: changed(coordinates=made("hex1")["coordinates"] * [1, 0, 0]), "coordinates: .* on one line"),
        (lambda: changed(coordinates=made("hex1")["coordinates"] * [1, 1, 1.1]), "it resists rigid rotation about x"),
        (lambda: changed(**of("mass", 0, 5, 1.0)), "mass: the matrix is unsymmetric"),
        (lambda: changed(**of("mass", 0, 0, 1.0)), "mass: it depends on the direction, expected equal x, y and z"),
        (lambda: changed(**of("mass", 0, 0, math.nan)), "mass: a matrix with nan"),
        (lambda: changed(**of("stiffness", 0, 0, 1e12)), "stiffness: it resists rigid translation along x"),
        (lambda: changed(node_sets={"a": [99]}), r"node_sets\['a'\]: node 99 was given"),
        (lambda: changed(node_sets={"a": [1, 1]}), r"node_sets\['a'\]: a node appears twice"),
        (lambda: changed(triangles=[[0, 1, 99]]), "triangles: node 99 was given"),
        (lambda: changed(triangles=[0, 1]), "triangles: an array of shape"),
        (lambda: changed(damping=np.eye(3)), "damping: an array of shape"),
        (lambda: solid().reduce(10**4), "modes: 10000 was given"),
        (lambda: solid().reduce(deformation="large"), "deformation: 'large' was given, expected 'linear'"),
        (lambda: solid().reduce(interfaces=["middle"]), r"interfaces\[0\]: 'middle' was given, expected one of"),
        (lambda: solid().reduce(clamped="edge"), "clamped: with its nodes held, the rest of the mesh can still move"),
        (lambda: solid().reduce(boundary="corner"), "boundary: with its nodes held, the rest of the mesh can still"),
        (lambda: solid().reduce(boundary="left", clamped="left"), "boundary: all of its nodes are clamped"),
        (lambda: solid().reduce(boundary="left", interfaces=["right"]), "boundary, interfaces: all were given"),
        (lambda: solid().reduce(damping=-0.1), "damping: -0.1 was given"),
        (lambda: solid().reduce(3, damping=[0.1]), "damping: an array of shape"),
        (lambda: solid().reduce(basis=np.ones((4, 2))), "basis: an array of shape"),
        (lambda: solid().reduce(3).at_nodes([10**6]), "nodes: node 1000000 was given"),
    ],
)
def test_what_cannot_be_is_refused(make, words):
    with pytest.raises(lf.ModelError, match=words):
        make()


def test_wrong_units_are_warned_of():
    given = made("hex1")
    with pytest.warns(lf.ModelWarning, match="waves run at about"):
        lf.SpatialMatrices(**given | {"stiffness": given["stiffness"] * 1e6})


def test_a_mesh_in_pieces_is_refused():
    one = made("hex1", (1, 1, 1))
    twice = {name: scipy.sparse.block_diag([one[name]] * 2).tocsc() for name in ("mass", "stiffness")}
    places = np.vstack([one["coordinates"], one["coordinates"] + [1.0, 0, 0]])
    with pytest.raises(lf.ModelError, match="the mesh falls into 2 pieces"):
        lf.SpatialMatrices(**twice, coordinates=places).reduce(2)
