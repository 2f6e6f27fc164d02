"""Bodies from a user's matrices: the same numbers as beams and bars, damping matrices, named sets, every bad input."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from scipy.sparse import block_diag, csr_array

from lcpflex.bodies import Bar, Beam, Chain, Continuum, Matrices, Rayleigh
from lcpflex.bodies.fem import meshes
from lcpflex.errors import ModelError, ModelWarning

E, RHO = 2e11, 7800.0


@lru_cache(maxsize=8)
def plate(nx: int, ny: int, length: float = 1.0, height: float = 0.1):
    """M, K (interleaved, sparse) and coordinates of a rectangle of bilinear elements, plane stress, nu = 0."""
    gauss = np.array([-1.0, 1.0]) / 3**0.5
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)
    hx, hy = length / nx, height / ny
    mass, stiff = np.zeros((8, 8)), np.zeros((8, 8))
    law = E * np.diag([1.0, 1.0, 0.5])
    for r in gauss:
        for s in gauss:
            shape = 0.25 * (1 + corners[:, 0] * r) * (1 + corners[:, 1] * s)
            dx = 0.5 / hx * corners[:, 0] * (1 + corners[:, 1] * s)
            dy = 0.5 / hy * corners[:, 1] * (1 + corners[:, 0] * r)
            strain = np.zeros((3, 8))
            strain[0, 0::2], strain[1, 1::2], strain[2, 0::2], strain[2, 1::2] = dx, dy, dy, dx
            stiff += 0.25 * hx * hy * strain.T @ law @ strain
            mass += 0.25 * hx * hy * RHO * np.kron(np.outer(shape, shape), np.eye(2))
    node = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    quads = np.stack([node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]], axis=-1).reshape(-1, 4)
    dofs = (2 * quads[:, :, None] + [0, 1]).reshape(-1, 8)
    places = (np.repeat(dofs, 8, axis=1).ravel(), np.tile(dofs, 8).ravel())
    x, y = np.meshgrid(np.linspace(0, length, nx + 1), np.linspace(-height / 2, height / 2, ny + 1), indexing="ij")
    m = csr_array((np.tile(mass.ravel(), len(quads)), places))
    k = csr_array((np.tile(stiff.ravel(), len(quads)), places))
    return m, k, np.column_stack([x.ravel(), y.ravel()])


def test_uniform_stretching_of_the_plate_is_the_bar():
    body = Matrices(*plate(12, 2)).reduce(None)
    bar = Bar(1.0, 0.1, RHO, E, elements=12).reduce()
    assert body.modes == 2 * 13 * 3 - 3
    for k in range(12):
        same = int(np.abs(body.stiffness / bar.stiffness[k] - 1).argmin())
        assert body.stiffness[same] == pytest.approx(bar.stiffness[k], rel=1e-9)
    assert body.mass == pytest.approx(bar.mass, rel=1e-12)
    first = int(np.abs(body.stiffness / bar.stiffness[0] - 1).argmin())
    assert abs(body.a[first]) == pytest.approx(abs(bar.a[0]), rel=1e-9)
    shape = body.locate(1.0, 0.05).phi[first]
    assert np.abs(shape) == pytest.approx([abs(bar.points["right"].phi[0, 0]), 0.0], abs=1e-9)


def test_a_slender_plate_bends_like_a_beam():
    """Timoshenko and rotary corrections are of order (t/L)^2; the mesh has aspect ratio 1 and full integration."""
    mesh = Matrices(*plate(800, 8, 1.0, 0.01))
    body = mesh.reduce(4)
    beam = Beam(1.0, 1.0, 0.01, RHO, E).reduce(4)
    assert body.frequencies() == pytest.approx(beam.frequencies(), rel=1.2e-2)
    tip, beam_tip = body.locate(1.0, 0.0), beam.points["right"]
    assert np.abs(tip.phi[:, 1]) == pytest.approx(np.abs(beam_tip.phi[:, 1]), rel=1e-2)
    assert np.abs(tip.psi) == pytest.approx(np.abs(beam_tip.psi), rel=2e-2)
    assert np.sign(tip.psi * tip.phi[:, 1]) == pytest.approx(np.sign(beam_tip.psi * beam_tip.phi[:, 1]))


def test_sparse_and_full_eigensolutions_agree(monkeypatch):
    mesh = Matrices(*plate(40, 4))
    full = mesh.reduce(10)
    monkeypatch.setattr("lcpflex.bodies.reduction.eigenmodes.DENSE_LIMIT", 0)
    sparse, again = mesh.reduce(10), mesh.reduce(10)
    assert sparse.stiffness == pytest.approx(full.stiffness, rel=1e-9)
    assert np.array_equal(sparse.stiffness, again.stiffness)
    assert np.abs(sparse.locate(0.0, 0.05).phi) == pytest.approx(np.abs(full.locate(0.0, 0.05).phi), abs=1e-6)


def test_integrals_do_not_depend_on_attitude_and_transform_with_the_frame():
    mass, stiffness, places = plate(10, 2)
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    here = Matrices(mass, stiffness, places).reduce(6)
    spread = block_diag([turn] * len(places)).tocsr()
    moved = Matrices(mass, spread @ stiffness @ spread.T, places @ turn.T + [3.0, -2.0]).reduce(6)
    assert moved.stiffness == pytest.approx(here.stiffness, rel=1e-8)
    assert moved.moment == pytest.approx(turn @ here.moment + here.mass * np.array([3.0, -2.0]))
    assert np.abs(moved.a) == pytest.approx(np.abs(here.a), abs=1e-8)  # S = 0: no shift
    assert here.coupling is not None
    assert moved.coupling is not None
    assert np.abs(moved.coupling) == pytest.approx(np.abs(here.coupling), abs=1e-8)
    assert np.array_equal(here.coupling, -here.coupling.T)


def test_all_modes_reproduce_any_nodal_field():
    mass, stiffness, places = plate(6, 2)
    body = Matrices(mass, stiffness, places).reduce(None)
    nodal = np.random.default_rng(1).standard_normal(places.shape)
    dx, dy, angle, modal = body.project(nodal)
    for k, place in enumerate(places):
        rigid = np.array([dx - angle * place[1], dy + angle * place[0]])
        assert rigid + body.locate(*place).phi.T @ modal == pytest.approx(nodal[k], abs=1e-9)


def test_rotation_of_the_material_is_exact_for_linear_fields():
    """psi of a combination of modes that make the field (0, g x) must be g/2: shear is half rotation."""
    mass, stiffness, places = plate(8, 2)
    body = Matrices(mass, stiffness, places).reduce(None)
    _, _, angle, modal = body.project(lambda x, y: (0.0, 1e-3 * x))
    for place in ((0.0, 0.05), (0.5, 0.0), (1.0, -0.05)):
        assert angle + body.locate(*place).psi @ modal == pytest.approx(0.5e-3, rel=1e-8)


def test_named_sets():
    mass, stiffness, places = plate(4, 1)
    ring = [0, 2, 4, 6, 8, 9, 7, 5, 3, 1, 0]
    body = Matrices(mass, stiffness, places, {"tip": 9, "root": [0], "outline": ring, "bottom": ring[:5]}).reduce(5)
    assert set(body.points) == {"tip", "root"}
    assert body.points["tip"].place == pytest.approx([1.0, 0.05])
    outline, bottom = body.surfaces["outline"], body.surfaces["bottom"]
    assert isinstance(outline, Chain)
    assert isinstance(bottom, Chain)
    assert (outline.closed, len(outline.points)) == (True, 10)
    assert (bottom.closed, len(bottom.points)) == (False, 5)
    assert [point.place[0] for point in bottom.points] == pytest.approx([0, 0.25, 0.5, 0.75, 1.0])


def test_damping_matrix():
    mass, stiffness, places = plate(6, 2)
    proportional = Matrices(mass, stiffness, places, damping=3.0 * mass + 1e-6 * stiffness).reduce(6)
    rayleigh = Matrices(mass, stiffness, places).reduce(6, damping=Rayleigh(3.0, 1e-6))
    assert proportional.damping == pytest.approx(rayleigh.damping, rel=1e-9)
    assert proportional.cross_damping is None
    damper = np.zeros((42, 42))
    damper[np.ix_([1, 41], [1, 41])] = 50.0 * np.array([[1, -1], [-1, 1]])
    local = Matrices(mass, stiffness, places, damping=damper).reduce(6)
    relative = local.locate(*places[0]).phi[:, 1] - local.locate(*places[20]).phi[:, 1]
    expected = 50.0 * np.outer(relative, relative)
    assert local.cross_damping is not None
    assert np.diag(local.damping) + local.cross_damping == pytest.approx(expected, abs=1e-9)
    assert np.diag(local.cross_damping) == pytest.approx(np.zeros(6))


def changed(name: str, change):
    """Matrices with one argument changed."""
    mass, stiffness, places = plate(4, 1)
    given = {"mass": mass.toarray(), "stiffness": stiffness.toarray(), "coordinates": places.copy()}
    given[name] = change(given[name])
    return Matrices(**given)


def bumped(matrix: np.ndarray, i: int, j: int, value: float) -> np.ndarray:
    out = matrix.copy()
    out[i, j] += value
    return out


def loose(stiffness: np.ndarray) -> np.ndarray:
    """The first element cut off: nodes 0 to 3 hold no other ones."""
    _, second, _ = plate(1, 1, 0.25)
    out = np.zeros_like(stiffness)
    out[:8, :8] += second.toarray()
    return out


def indefinite(stiffness: np.ndarray) -> np.ndarray:
    """Minus a stretching spring between two opposite nodes: free of rigid forces, but negative."""
    out = stiffness.copy()
    out[np.ix_([0, 16], [0, 16])] -= 1e13 * np.array([[1, -1], [-1, 1]])
    return out


def not_definite(mass: np.ndarray) -> np.ndarray:
    """Positive diagonal, rigid mass unchanged, yet a negative eigenvalue."""
    out = mass.copy()
    big = 10 * mass.max()
    for c in (0, 1):
        out[c, 2 + c] += big
        out[2 + c, c] += big
        out[c, 16 + c] -= big
        out[16 + c, c] -= big
    return out


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: changed("stiffness", lambda k: bumped(k, 0, 3, 1e9)), "stiffness: .*unsymmetric"),
        (lambda: changed("mass", lambda m: bumped(m, 0, 2, 1.0)), "mass: .*unsymmetric"),
        (lambda: changed("stiffness", lambda k: bumped(k, 0, 0, float("nan"))), "stiffness: .*nan"),
        (lambda: changed("mass", lambda m: csr_array(bumped(m, 0, 0, float("inf")))), "mass: .*inf"),
        (lambda: changed("coordinates", lambda x: x * float("nan")), "coordinates: .*nan"),
        (lambda: changed("coordinates", lambda x: x * 0.0), "coordinates: .*one place"),
        (lambda: changed("coordinates", lambda x: x[:-1]), r"mass: .*\(20, 20\).*\(18, 18\)"),
        (lambda: changed("stiffness", lambda k: csr_array(k[:4, :4])), r"stiffness: .*\(4, 4\)"),
        (lambda: changed("stiffness", lambda k: bumped(k, 0, 0, 1e9)), "joints"),
        (lambda: changed("stiffness", lambda k: k + 1e9 * np.eye(20)), "free-free"),
        (lambda: changed("mass", lambda m: -m), "mass: .*positive"),
        (lambda: changed("mass", lambda m: bumped(m, 0, 0, 5.0)), "mass: .*direction"),
        (lambda: changed("mass", not_definite).reduce(3), "mass: .*positive definite"),
        (lambda: changed("stiffness", loose).reduce(3), "mechanisms"),
        (lambda: changed("stiffness", loose).reduce(0), "mechanisms"),
        (lambda: changed("stiffness", indefinite).reduce(3), "semidefinite"),
        (lambda: Matrices(*plate(4, 1)).reduce(18), "modes: 18 .*17"),
        (lambda: Matrices(*plate(4, 1), {"tip": 10}), r"node_sets\['tip'\]: node 10 .*9"),
        (lambda: Matrices(*plate(4, 1), {"tip": -1}), "node -1"),
        (lambda: Matrices(*plate(4, 1), [1, 2]), "node_sets: .*expected a mapping"),
        (lambda: Matrices(*plate(4, 1), {"tip": 1.5}), "1.5 was given"),
        (lambda: Matrices(*plate(4, 1), {"side": []}), "side"),
        (lambda: Matrices(*plate(4, 1), {"side": [0, 1, 2, 1]}), "twice"),
        (lambda: Matrices(*plate(4, 1)).reduce(2).locate(0.1, 0.1), "node"),
        (lambda: Matrices(*plate(4, 1), damping=plate(4, 1)[1]).reduce(2, damping=0.1), "one of the two"),
        (lambda: Matrices(*plate(4, 1), damping=-1e-5 * plate(4, 1)[1]).reduce(2), "feeds energy"),
        (lambda: Matrices(*plate(4, 1)).reduce(2).project(np.zeros((3, 2))), "3 nodal values .*10"),
    ],
)
def test_bad_input(make, message):
    with pytest.raises(ModelError, match=message):
        make()


def test_large_indefinite_or_loose_matrices_are_refused(monkeypatch):
    monkeypatch.setattr("lcpflex.bodies.reduction.eigenmodes.DENSE_LIMIT", 0)
    with pytest.raises(ModelError, match=r"indefinite|semidefinite"):
        changed("stiffness", indefinite).reduce(1)
    with pytest.raises(ModelError, match=r"mass: .*definite"):
        changed("mass", not_definite).reduce(1)
    mass, stiffness, places = plate(10, 2)
    twice = np.vstack([places, places + np.array([0.0, 1.0])])
    pair = Matrices(block_diag([mass, mass]), block_diag([stiffness, stiffness]), twice)
    with pytest.raises(ModelError, match="mechanisms"):
        pair.reduce(4)


def test_matrices_whose_units_do_not_fit_are_told() -> None:
    """In N, mm and t, or with the modulus in GPa: gravity and lengths of the scene would be wrong without a word."""
    mesh = Continuum(meshes.rectangle(0.2, 0.05, 8, 2, order=1), 7800.0, 2.1e11, 0.3).finite_elements()
    Matrices(mesh.mass, mesh.stiffness, mesh.places)
    for mass, stiffness, length in ((1e-3, 1e-3, 1e3), (1.0, 1e-9, 1.0)):
        with pytest.warns(ModelWarning, match="which no material has: expected N/m, kg and m"):
            Matrices(mass * mesh.mass, stiffness * mesh.stiffness, length * mesh.places)
