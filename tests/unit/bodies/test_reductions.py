"""Component mode synthesis: analytic and full-mesh frequencies, exact static loads, rates, no rigid content."""

from __future__ import annotations

from functools import cache, partial

import numpy as np
import pytest
from scipy.linalg import eigh

import lcpflex as lf
from lcpflex.bodies.continuum import Continuum
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.matrices import Matrices
from lcpflex.bodies.reduction.component_modes import (
    craig_bampton,
    free_interface,
    residual_compliance,
    sub_regional,
    unreduced,
)
from lcpflex.bodies.reduction.stiffening import Stiffening
from lcpflex.bodies.solid_of_revolution import SolidOfRevolution
from tests.rates import assert_rate

# Coarse linear meshes, for short runs: what is reduced has all of their stiffness, right or not.
pytestmark = pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.errors.ModelWarning")

E, RHO = 2e11, 7800.0
SPEED = (E / RHO) ** 0.5
REDUCTIONS = {
    "free_interface": partial(free_interface, modes=12),
    "craig_bampton": partial(craig_bampton, boundary=["left", "right"], modes=6),
    "sub_regional": partial(sub_regional, region="tip", modes=6),
    "sub_regional, plain": partial(sub_regional, region="tip", modes=6, interface_modes=False),
    "residual_compliance": partial(residual_compliance, contact="right", modes=6),
    "unreduced": unreduced,
}


@cache
def plate(nx: int = 20, ny: int = 4, nu: float = 0.3) -> Continuum:
    """1 m by 0.2 m, with its right-most quarter as a region."""
    tip = {"tip": lambda x, y: x > 0.76}
    return Continuum(meshes.rectangle(1.0, 0.2, nx, ny, order=1), RHO, E, nu, sets=tip)


@cache
def rod(nx: int = 16, ny: int = 3) -> SolidOfRevolution:
    """A cylinder of 1 m, radius 0.2 m."""
    tip = {"tip": lambda x, y: x > 0.76}
    return SolidOfRevolution(meshes.rectangle(1.0, 0.2, nx, ny, order=1), RHO, E, 0.3, sets=tip)


def shapes_at(body: lf.Body, model: Continuum | SolidOfRevolution, nodes: np.ndarray) -> np.ndarray:
    """(n, 2 k) mode shapes at nodes."""
    places = model.finite_elements().places[nodes]
    return np.hstack([body.locate(float(x), float(y)).phi for x, y in places])


def balanced_static(model: Continuum | SolidOfRevolution, loads: np.ndarray) -> np.ndarray:
    """(f, k) static displacements under loads (f, k) balanced by inertia, M-orthogonal to the rigid motions."""
    mesh = model.finite_elements()
    weighed = mesh.mass @ mesh.rigid
    r = weighed.shape[1]
    whole = np.block([[mesh.stiffness.toarray() / E, weighed], [weighed.T, np.zeros((r, r))]])
    return np.linalg.solve(whole, np.vstack([loads / E, np.zeros((r, loads.shape[1]))]))[: len(loads)]


def unit_loads(model: Continuum | SolidOfRevolution, nodes: np.ndarray) -> np.ndarray:
    mesh = model.finite_elements()
    rows = np.flatnonzero(np.isin(mesh.dofs // 2, nodes))
    loads = np.zeros((len(mesh.dofs), len(rows)))
    loads[rows, np.arange(len(rows))] = 1.0
    return loads


def compliance(body: lf.Body, model: Continuum | SolidOfRevolution, nodes: np.ndarray) -> np.ndarray:
    """Of the elastic coordinates, at the degrees of freedom of the nodes."""
    phi = shapes_at(body, model, nodes)
    dofs = (2 * nodes[:, None] + [0, 1]).ravel()
    phi = phi[:, np.isin(dofs, model.finite_elements().dofs)]
    return phi.T @ (phi / body.stiffness[:, None])


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_slender_bars_have_the_frequencies_of_beam_and_bar(nu: float) -> None:
    """Shear and rotary inertia lower bending by parts (h/L)^2, and so does contraction the stretching."""
    heights = np.array([0.04, 0.02, 0.01])
    errors = []
    for height in heights:
        mesh = meshes.bar(1.0, float(height), 150)
        found = free_interface(Continuum(mesh, RHO, E, nu), 12).frequencies()
        bending = np.array([4.73004074, 7.85320462, 10.9956078]) ** 2 * SPEED * height / 12**0.5
        errors.append(1.0 - found[:3] / bending)
        assert np.abs(found / (np.pi * SPEED) - 1.0).min() < 1e-4
    assert_rate(heights, errors, 2.0, within=0.05)
    assert errors[-1].max() < 2e-3


@pytest.mark.parametrize("make", [plate, rod], ids=["plane", "axisymmetric"])
def test_lowest_modes_are_those_of_the_full_mesh(make, monkeypatch) -> None:
    model = make()
    mesh = model.finite_elements()
    omega2 = eigh(mesh.stiffness.toarray(), mesh.mass.toarray(), eigvals_only=True)[mesh.rigid.shape[1] :]
    full = unreduced(model)
    assert full.stiffness == pytest.approx(omega2, rel=1e-9)
    monkeypatch.setattr("lcpflex.bodies.reduction.eigenmodes.DENSE_LIMIT", 0)
    assert free_interface(model, 10).stiffness == pytest.approx(omega2[:10], rel=1e-10)


@pytest.mark.parametrize("name", REDUCTIONS)
@pytest.mark.parametrize("make", [plate, rod], ids=["plane", "axisymmetric"])
def test_no_rigid_content_and_the_same_mass(name: str, make) -> None:
    model = make()
    body, full = REDUCTIONS[name](model), unreduced(model)
    mesh = model.finite_elements()
    assert body.mass == pytest.approx(full.mass, rel=1e-13)
    assert body.inertia == pytest.approx(full.inertia, rel=1e-13)
    assert (body.S == 0.0).all()
    assert (body.c == 0.0).all()
    assert body.axisymmetric == (name != "" and mesh.axisymmetric)
    assert (body.stiffness >= full.stiffness[: body.modes] * (1.0 - 1e-9)).all()  # Rayleigh-Ritz
    for motion in mesh.rigid.T:
        assert body.project(mesh.nodal(motion[:, None])[:, :, 0])[3] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("craig_bampton", 2 * 10 + 6 - 3),  # 5 nodes a side
        ("sub_regional", 2 * 25 + 6),  # 5 x 5 nodes; three rigid motions added and removed
        ("sub_regional, plain", 2 * 20 + 6),
        ("residual_compliance", 6 + 2 * 5),
        ("unreduced", 2 * 105 - 3),
    ],
)
def test_number_of_coordinates(name: str, expected: int) -> None:
    assert REDUCTIONS[name](plate()).modes == expected


@pytest.mark.parametrize("make", [plate, rod], ids=["plane", "axisymmetric"])
def test_craig_bampton_is_exact_for_balanced_loads_on_the_boundary(make) -> None:
    model = make()
    mesh = model.finite_elements()
    nodes = np.union1d(mesh.sets["left"], mesh.sets["right"])
    loads = unit_loads(model, nodes)
    own = loads.T @ mesh.rigid
    balance = np.eye(len(own)) - own @ np.linalg.solve(own.T @ own, own.T)
    exact = balance @ loads.T @ balanced_static(model, loads @ balance)
    body = craig_bampton(model, ["left", "right"], 0)
    found = balance @ compliance(body, model, nodes) @ balance
    assert np.abs(found - exact).max() < 1e-9 * np.abs(exact).max()


def test_craig_bampton_converges_from_above() -> None:
    full = unreduced(plate()).stiffness[:4]
    counts = np.array([5, 10, 20, 40, 80])
    errors = np.array([craig_bampton(plate(), ["left", "right"], int(n)).stiffness[:4] / full - 1.0 for n in counts])
    assert (errors > 0.0).all()
    assert_rate(counts, errors, -2.5, within=1.0)


@pytest.mark.parametrize("make", [plate, rod], ids=["plane", "axisymmetric"])
@pytest.mark.parametrize("modes", [0, 5])
def test_residual_compliance_is_exact_at_the_contact_nodes(make, modes: int) -> None:
    model = make()
    nodes = model.finite_elements().sets["right"]
    loads = unit_loads(model, nodes)
    exact = loads.T @ balanced_static(model, loads)
    found = compliance(residual_compliance(model, "right", modes), model, nodes)
    assert np.abs(found - exact).max() < 1e-9 * np.abs(exact).max()
    kept = compliance(free_interface(model, modes), model, nodes) if modes else 0.0 * exact
    assert np.abs(kept - exact).max() > 1e-2 * np.abs(exact).max()


def test_kept_modes_stay_and_the_residual_ones_lie_above_them() -> None:
    body, kept, full = residual_compliance(plate(), "right", 8), free_interface(plate(), 8), unreduced(plate())
    assert np.array_equal(body.stiffness[:8], kept.stiffness)
    assert np.array_equal(body.locate(1.0, 0.1).phi[:8], kept.locate(1.0, 0.1).phi)
    assert body.stiffness[8:].min() > full.stiffness[8] * (1.0 - 1e-9)


def test_massless_boundary_has_the_compliance_of_the_full_mesh() -> None:
    """The stepper takes the modes above the kept ones for the compliance of contacts."""
    modes, model = 6, plate()
    body = residual_compliance(model, "left", modes, damping=0.05)
    scene = lf.Scene(gravity=(0.0, 0.0))
    placed = scene.add(body, name="plate", position=(1e-6, 0.0), velocity=(-0.1, 0.0))
    wall = scene.ground.half_plane((0.0, 0.0), (1.0, 0.0))
    scene.contact(placed.surface("left"), wall, name="wall")
    result = lf.simulate(scene, 2e-4, lf.MasslessBoundary(dynamic_modes=modes), progress=False)
    assert np.nanmin(result.gap) < 1e-9
    assert result.u[-1, 0] > -0.1
    nodes = model.finite_elements().sets["left"]
    phi = shapes_at(body, model, nodes)
    static = np.argsort(body.stiffness, kind="stable")[modes:]
    used = phi[static].T @ (phi[static] / body.stiffness[static][:, None])
    loads = unit_loads(model, nodes)
    low = free_interface(model, modes)
    exact = loads.T @ balanced_static(model, loads) - compliance(low, model, nodes)
    assert np.abs(used - exact).max() < 1e-9 * np.abs(exact).max()


def pulse_response(body: lf.Body, model: Continuum, node: int, times: np.ndarray, pulse: float) -> np.ndarray:
    """(t,) elastic displacement at a node along x under a force sin(pi t / pulse), 0 < t < pulse, there."""
    phi = shapes_at(body, model, np.array([node]))[:, 0]
    omega, p = np.sqrt(body.stiffness), np.pi / pulse
    out = np.zeros(len(times))
    for since in (times, times - pulse):
        t = np.maximum(since, 0.0)[:, None]
        out += ((omega * np.sin(p * t) - p * np.sin(omega * t)) / (omega**2 - p**2)) @ (phi**2 / omega)
    return out


@cache
def regional_errors(interface_modes: bool) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of modes; errors of four frequencies, of a static load and of the response to a pulse at the tip."""
    model = plate(40, 8)
    full = unreduced(model)
    tip = int(np.argmin(np.hypot(*(model.finite_elements().places - [1.0, 0.1]).T)))
    loads = unit_loads(model, np.array([tip]))
    exact = loads.T @ balanced_static(model, loads)
    times = np.linspace(0.0, 4.0 / SPEED, 400)
    response = pulse_response(full, model, tip, times, 0.5 / SPEED)
    counts = np.array([5, 10, 20, 40, 80, 160])
    errors = []
    for n in counts:
        body = sub_regional(model, "tip", int(n), interface_modes=interface_modes)
        frequencies = np.sqrt(body.stiffness[:4] / full.stiffness[:4]) - 1.0
        static = np.linalg.norm(compliance(body, model, np.array([tip])) - exact) / np.linalg.norm(exact)
        moved = np.linalg.norm(pulse_response(body, model, tip, times, 0.5 / SPEED) - response) / np.linalg.norm(
            response
        )
        errors.append([*frequencies, static, moved])
    return counts, np.array(errors)


@pytest.mark.slow
def test_sub_regional_converges_to_the_full_mesh() -> None:
    counts, errors = regional_errors(True)
    assert_rate(counts, errors[:, :4], -3.0, within=(9.0, 0.5))
    assert errors[-1, :4].max() < 1e-7
    assert errors[:, 4].max() < 1e-9  # static loads in the region are exact
    assert_rate(counts, errors[:, 5], -1.0, within=(9.0, 0.5))
    assert errors[-1, 5] < 0.05


@pytest.mark.slow
def test_sub_regional_as_published_converges_slowly() -> None:
    """Free modes have no traction at the interface: first order, frequencies and static loads alike."""
    counts, errors = regional_errors(False)
    assert_rate(counts, errors[:, :5], -1.0, within=(0.6, 0.3))
    assert errors[-1, 4] > 1e-3


def test_the_same_input_gives_the_same_bits(monkeypatch) -> None:
    monkeypatch.setattr("lcpflex.bodies.reduction.eigenmodes.DENSE_LIMIT", 0)
    for make in list(REDUCTIONS.values())[:-1]:
        one, two = make(plate()), make(plate())
        assert np.array_equal(one.stiffness, two.stiffness)
        assert np.array_equal(one.locate(1.0, 0.2).phi, two.locate(1.0, 0.2).phi)


def test_modes_of_equal_frequency_are_all_found(monkeypatch) -> None:
    """A ring has its modes in pairs."""
    model = Continuum(meshes.ring(0.5, 1.0, 48, 3), RHO, E, 0.3)
    full = unreduced(model).stiffness
    monkeypatch.setattr("lcpflex.bodies.reduction.eigenmodes.DENSE_LIMIT", 0)
    assert np.count_nonzero(np.diff(full[:15]) < 1e-8 * full[:14]) >= 4
    for n in (1, 2, 3, 8, 15):
        assert free_interface(model, n).stiffness == pytest.approx(full[:n], rel=1e-9)


@pytest.mark.parametrize("name", REDUCTIONS)
def test_damping_and_stiffening_reach_every_reduction(name: str) -> None:
    mesh = plate().finite_elements()
    sets = {key: mesh.sets[key].tolist() for key in ("left", "right", "tip")}
    damped = Matrices(mesh.mass, mesh.stiffness, mesh.places, sets, damping=3.0 * mesh.mass + 1e-6 * mesh.stiffness)
    body = REDUCTIONS[name](damped)
    assert body.damping == pytest.approx(3.0 + 1e-6 * body.stiffness, rel=1e-7)
    assert body.cross_damping is None
    pull = Stiffening(held="left", axial_force=1e9)
    stiff, loose = (REDUCTIONS[name](plate(), stiffening=given).stiffness[0] for given in (pull, None))
    full, full_loose = (unreduced(plate(), stiffening=given).stiffness[0] for given in (pull, None))
    assert full > 1.05 * full_loose
    assert stiff / loose == pytest.approx(full / full_loose, rel=3e-2 if "plain" in name else 5e-3)
    body = REDUCTIONS[name](plate(), stiffening=pull)
    assert body.geometric is not None
    assert [level.make().geometric is not None for level in body.fidelity_levels()[1:3]] == [True, True]


@pytest.mark.parametrize("name", ["craig_bampton", "sub_regional", "residual_compliance"])
def test_free_flight_conserves_energy(name: str) -> None:
    body = REDUCTIONS[name](plate(10, 2))
    scene = lf.Scene(gravity=(0.0, 0.0))
    start = np.zeros(body.modes)
    start[:3] = 1e-3 * np.arange(3, 0, -1)
    scene.add(body, name="plate", velocity=(1.0, 2.0), angular_velocity=50.0, modal=start)
    result = lf.simulate(scene, 2e-4, lf.EventDriven(), progress=False)
    stored = result.energies.kinetic + result.energies.elastic
    assert np.ptp(stored) < 1e-3 * np.ptp(result.energies.elastic)
    assert np.ptp(stored) < 1e-6 * stored[0]
