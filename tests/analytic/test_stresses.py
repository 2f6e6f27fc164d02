"""Stresses of meshes and beams against closed forms and against whole meshes."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.fem.assembly import ElasticSolid
from lcpflex.bodies.fem.nodal_stress import nodal_gradients, nodal_stress
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

E, NU, DENSITY = 2e11, 0.3, 7800.0


def run(scene: lf.Scene, duration: float, stepper: Any, record: float | None = None) -> lf.Result:
    return lf.simulate(scene, duration, stepper, record=record or duration, progress=False)


def node_of(places: FloatArray, x: float, y: float) -> int:
    return int(np.hypot(*(places - [x, y]).T).argmin())


def solid_of(part: Any) -> ElasticSolid:
    solid = part.finite_elements().solid
    assert solid is not None
    return solid


MESHES = {
    "quadratic quadrilaterals": lambda: lf.meshes.bar(1, 0.2, 6, across=2),
    "quadrilaterals": lambda: lf.meshes.bar(1, 0.2, 6, across=2, order=1),
    "quadratic triangles": lambda: lf.meshes.bar(1, 0.2, 6, across=2, triangles=True),
    "triangles": lambda: lf.meshes.bar(1, 0.2, 6, across=2, triangles=True, order=1),
    "curved quadrilaterals": lambda: lf.meshes.ring(0.5, 1, 12, 2),
}


@pytest.mark.parametrize("kind", MESHES)
@pytest.mark.parametrize("plane_strain", [False, True])
def test_uniform_strain(kind: str, plane_strain: bool) -> None:
    """Hooke's law at every node, to rounding."""
    solid = solid_of(lf.Continuum(MESHES[kind](), DENSITY, E, NU, plane_strain=plane_strain))
    x, y = solid.mesh.places.T
    u = np.column_stack([1e-3 * x + 2e-3 * y, 1e-3 * x - 5e-4 * y])[:, :, None]
    (xx, yy), shear = (1e-3, -5e-4), E / (2.0 * (1.0 + NU)) * 3e-3
    a, b = (1.0 - NU, NU) if plane_strain else (1.0, NU)
    factor = E / ((1.0 + NU) * (1.0 - 2.0 * NU)) if plane_strain else E / (1.0 - NU**2)
    exact = [factor * (a * xx + b * yy), factor * (b * xx + a * yy), shear, 0.0]
    exact[3] = NU * (exact[0] + exact[1]) if plane_strain else 0.0
    found = nodal_stress(solid, nodal_gradients(solid), u)[:, :, 0]
    assert found == pytest.approx(np.array(exact)[:, None] * np.ones(len(x)), abs=1e-12 * shear)


def test_uniform_strain_about_an_axis() -> None:
    """u_x = a x, u_r = b r: the hoop has the strain b, too."""
    mesh = lf.meshes.half_section_of_rod(1.0, 0.2, 0.1)
    solid = solid_of(lf.SolidOfRevolution(mesh, DENSITY, E, NU))
    x, r = solid.mesh.places.T
    a, b = 1e-3, -2e-4
    found = nodal_stress(solid, nodal_gradients(solid), np.column_stack([a * x, b * r])[:, :, None])[:, :, 0]
    lame, shear = E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU)), E / (2.0 * (1.0 + NU))
    volume = lame * (a + 2.0 * b)
    exact = np.array([volume + 2.0 * shear * a, volume + 2.0 * shear * b, 0.0, volume + 2.0 * shear * b])
    assert found == pytest.approx(exact[:, None] * np.ones(len(x)), abs=1e-12 * exact[0])


def cantilever(how: str, tip: Any, modes: int = 20) -> tuple[lf.Scene, Any]:
    """A meshed cantilever of 1 m, 0.1 m high, held at the corners of its end."""
    plate = lf.Continuum(lf.meshes.bar(1.0, 0.1, 20, across=2), DENSITY, E, NU, thickness=0.05)
    ends = {"boundary": [node_of(plate.finite_elements().places, x, y) for x in (0.0, 1.0) for y in (-0.05, 0, 0.05)]}
    bodies = {
        "modes": lambda: plate.reduce(modes, damping=0.02),
        "craig_bampton": lambda: lf.craig_bampton(plate, ends["boundary"], modes, damping=0.02),
        "whole": lambda: lf.unreduced(plate, damping=0.02),
    }
    scene = lf.Scene(gravity=(0, 0))
    b = scene.add(bodies[how](), name="bar")
    scene.join(lf.Revolute(b.at(0.0, -0.05), scene.ground.at(0, -0.05)))
    scene.join(lf.PointOnLine(b.at(0.0, 0.05), scene.ground.at(0, 0.05), axis=(0, 1)))
    scene.load(lf.Force(b.at(1.0, 0.0), tip))
    return scene, b


@pytest.mark.parametrize("how", ["modes", "craig_bampton"])
def test_cantilever_bends(how: str) -> None:
    """sigma_xx = -M y / I half-way, of a force at the tip that dampers bring to rest."""
    scene, b = cantilever(how, (0.0, -1e4))
    for x in (0.5, 1.0):
        point = b.at(x, 0.0)
        scene.load(lf.Spring(point, scene.ground.at(x + 0.3, -0.4), stiffness=0.0, damping=2e4))
    result = run(scene, 0.2, lf.GeneralizedAlpha(2e-4))
    history = result.stress("bar")
    stress = history.at(0.2)
    for x, y in ((0.5, 0.05), (0.5, -0.05), (0.25, 0.05)):
        k = node_of(history.places, x, y)
        exact = 1e4 * (1.0 - x) * y / (0.05 * 0.1**3 / 12.0)
        assert stress.xx[k] == pytest.approx(exact, rel=5e-3)
        assert stress.von_mises[k] == pytest.approx(abs(exact), rel=5e-3)
    assert not stress.zz.any()


@cache
def plate_with_hole(around: int = 48, through: int = 8, order: int = 2) -> tuple[lf.Continuum, FloatArray]:
    """A square of 1 m with a hole of 0.1 m, elements that grow outwards; and the nodal loads of a tension of 1 Pa.

    The loads are those of elements of order 2.
    """
    ring = lf.meshes.ring(0.05, 1.0, around, through, order=order)
    x, y = np.asarray(ring.doflocs)
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    edge = 0.5 / np.maximum(np.abs(np.cos(angle)), np.abs(np.sin(angle)))
    radius = 0.05 * (edge / 0.05) ** ((radius - 0.05) / 0.95)
    mesh = type(ring)(np.stack([radius * np.cos(angle), radius * np.sin(angle)]), ring.t)
    plate = lf.Continuum(mesh, DENSITY, E, NU, thickness=1.0)
    places = plate.finite_elements().places
    force = np.zeros(len(places))
    for end in (-0.5, 0.5):
        nodes = np.flatnonzero(np.abs(places[:, 0] - end) < 1e-9)
        nodes = nodes[np.argsort(places[nodes, 1])]
        for first in range(0, len(nodes) - 1, 2):
            three = nodes[first : first + 3]
            low, middle, high = places[three, 1] - places[three[0], 1]
            s, w = np.polynomial.legendre.leggauss(4)
            s = 0.5 * high * (s + 1.0)
            shapes = [np.polyfit([low, middle, high], one, 2) for one in np.eye(3)]
            force[three] += math.copysign(1.0, end) * np.array([(0.5 * high * w) @ np.polyval(p, s) for p in shapes])
    return plate, force


@pytest.mark.parametrize(
    ("how", "elements"),
    [
        pytest.param("modes", (48, 8), id="modes"),
        pytest.param("craig_bampton", (48, 8), id="craig_bampton", marks=pytest.mark.slow),
        pytest.param("modes", (64, 10), id="finer", marks=pytest.mark.slow),
        pytest.param("modes", (96, 14), id="finest", marks=pytest.mark.slow),
    ],
)
def test_plate_with_a_hole(how: str, elements: tuple[int, int]) -> None:
    """Gross factor 3.03 at a hole of a tenth of the width (Peterson; Heywood: 3.032), by 20 modes and statics."""
    plate, force = plate_with_hole(*elements)
    ends = np.flatnonzero(force)
    body = plate.reduce(20, damping=0.7) if how == "modes" else lf.craig_bampton(plate, ends[::8], 20, damping=0.7)
    scene = lf.Scene(gravity=(0, 0))
    b = scene.add(body, name="plate")
    places = plate.finite_elements().places
    for k in ends.tolist():
        scene.load(lf.Force(b.at(*places[k].tolist()), (1e8 * float(force[k]), 0.0)))
    result = run(scene, 2e-3, lf.GeneralizedAlpha(2e-5))
    history = result.stress("plate")
    stress, modes_only = history.at(2e-3), result.stress("plate", static=False).at(2e-3)
    assert stress.xx[node_of(history.places, 0.0, 0.05)] / 1e8 == pytest.approx(3.03, rel=0.02)
    assert stress.xx.max() / 1e8 == pytest.approx(3.03, rel=0.02)
    assert stress.yy[node_of(history.places, 0.05, 0.0)] / 1e8 == pytest.approx(-1.0, abs=0.05)
    if how == "modes":  # which know little of a hole
        assert abs(modes_only.xx[node_of(history.places, 0.0, 0.05)] / 1e8 - 3.03) > 0.3


def test_craig_bampton_recovers_the_whole_mesh() -> None:
    """A force at the tip within a period of the third bending mode: stresses at all times and places within 2 %."""
    pulse = lf.Table([0.0, 2e-4, 4e-4], [0.0, -1e4, 0.0])
    peaks, late = {}, {}
    for how in ("whole", "craig_bampton"):
        scene, _ = cantilever(how, (0.0, pulse))
        history = run(scene, 4e-3, lf.GeneralizedAlpha(1e-5), record=2e-4).stress("bar")
        peaks[how], late[how] = history.peak(), history.all()
    inside = history.places[:, 0] > 0.05  # held at two nodes: there stress grows with the mesh without end
    scale = peaks["whole"][inside].max()
    assert np.abs(peaks["craig_bampton"] - peaks["whole"])[inside].max() < 0.02 * scale
    for part in ("xx", "yy", "xy"):
        apart = np.abs(getattr(late["craig_bampton"], part) - getattr(late["whole"], part))[:, inside]
        assert apart.max() < 0.02 * scale


@pytest.mark.parametrize("kind", ["bar", "mesh"])
def test_struck_bar(kind: str) -> None:
    """-rho c v0 behind the front of a bar that meets a wall: the mean of the plateau 0.2 %, its ripple 4 %."""
    c, v0, area = math.sqrt(E / DENSITY), 1.0, 1e-4
    scene = lf.Scene(gravity=(0, 0))
    wall = scene.ground.half_plane((0, 0), (1, 0))
    if kind == "bar":
        b = scene.add(lf.Bar(1.0, area, DENSITY, E).reduce(None), name="bar", velocity=(-v0, 0))
        scene.contact(b.node(0, 0), wall, restitution=0.0)
    else:
        mesh = lf.Continuum(lf.meshes.bar(1.0, 0.01, 60), DENSITY, E, NU, thickness=0.01)
        b = scene.add(mesh.reduce(60), name="bar", velocity=(-v0, 0))
        scene.contact(b.surface("left"), wall, restitution=0.0)
    history = run(scene, 0.7 / c, lf.GeneralizedAlpha(1e-6)).stress("bar")
    plateau = (history.places[:, 0] > 0.05) & (history.places[:, 0] < 0.6)
    share = -history.at(0.7 / c).xx / (DENSITY * c * v0)
    assert share[plateau].mean() == pytest.approx(1.0, abs=2e-3)
    assert np.abs(share[plateau] - 1.0).max() < 0.04
    assert np.abs(share[history.places[:, 0] > 0.8]).max() < 0.15  # not there yet, but for what precedes the front


def test_beam_and_bar() -> None:
    """M / W on top and bottom, 3 V / (2 A) on the axis, of a cantilever that is at rest from the start."""
    scene = lf.Scene(gravity=(0, 0))
    b = scene.add(lf.Beam(1.0, 0.02, 0.04, DENSITY, E, elements=4), name="beam", modes=0)
    scene.join(lf.Weld(b.point("left"), scene.ground.at(0, 0)))
    scene.load(lf.Force(b.point("right"), (800.0, -100.0)))
    bar = scene.add(lf.Bar(1.0, 0.01, DENSITY, E, elements=4), name="bar", modes=0, position=(0, 1))
    scene.join(lf.Weld(bar.point("left"), scene.ground.at(0, 1)))
    scene.load(lf.Force(bar.point("right"), (800.0, 0.0)))
    result = run(scene, 0.01, lf.MoreauJean(1e-3))
    history = result.stress("beam")
    x, y = history.places.T
    stress = history.at(0.01)
    assert stress.xx == pytest.approx(1e6 + 100.0 * (1.0 - x) * y / (0.02 * 0.04**3 / 12.0), rel=1e-6)
    assert stress.xy == pytest.approx(np.where(y == 0.0, -1.5 * 100.0 / 8e-4, 0.0), abs=1e-6)
    assert stress.von_mises[y == 0.0] == pytest.approx(math.sqrt(1e12 + 3.0 * (1.5 * 100.0 / 8e-4) ** 2), rel=1e-9)
    assert history.peak() == pytest.approx(history.all().von_mises.max(axis=0))
    assert result.stress("bar").at(0.01).xx == pytest.approx(8e4 * np.ones(5))


def test_spin_of_a_meshed_ring() -> None:
    """sigma of a thin ring that spins is rho omega^2 r^2 along it, from the static part alone: no mode is round."""
    omega, r = 100.0, 1.0
    ring = lf.Continuum(lf.meshes.ring(0.98, 1.02, 64, 1), DENSITY, E, NU)
    scene = lf.Scene(gravity=(0, 0))
    scene.add(ring.reduce(3), name="ring", angular_velocity=omega, angle=0.3)
    history = run(scene, 0.01, lf.MoreauJean(1e-4)).stress("ring")
    stress = history.at(0.01)
    k = node_of(history.places, 0.0, r)
    assert stress.xx[k] == pytest.approx(DENSITY * omega**2 * r**2, rel=5e-3)
    assert stress.von_mises == pytest.approx(DENSITY * omega**2 * np.ones(len(history.places)), rel=0.03)


def test_plane_strain_and_files(tmp_path: Any) -> None:
    """sigma_zz = nu (sigma_xx + sigma_yy) in plane strain; a loaded result tells the same."""
    plate = lf.Continuum(lf.meshes.bar(1.0, 0.1, 10), DENSITY, E, NU, plane_strain=True)
    scene = lf.Scene(gravity=(0, -9.81))
    b = scene.add(plate.reduce(4), name="plate")
    scene.join(lf.Revolute(b.at(0.0, 0.0), scene.ground.at(0, 0)))
    result = run(scene, 0.01, lf.MoreauJean(1e-3), record=5e-3)
    stress = result.stress("plate").all()
    assert np.abs(stress.xx).max() > 1e4
    assert stress.zz == pytest.approx(NU * (stress.xx + stress.yy), abs=1e-9 * np.abs(stress.xx).max())
    loaded = lf.Result.load(result.save(tmp_path / "plate.npz")).stress("plate").all()
    assert (loaded.von_mises == stress.von_mises).all()


def test_what_cannot_be_told() -> None:
    scene = lf.Scene(gravity=(0, -9.81))
    scene.add(lf.Disc(0.1, mass=1.0), name="disc")
    scene.add(lf.Beam(1.0, 0.02, 0.04, DENSITY, E, elements=4), name="beam", modes=2, position=(0, 1))
    result = run(scene, 0.01, lf.MoreauJean(1e-3))
    with pytest.raises(ModelError, match="'disc' was given, expected a Beam, a Bar, or a body with modes"):
        result.stress("disc")
    with pytest.raises(ModelError, match="static: False was given"):
        result.stress("beam", static=False)
    with pytest.raises(ModelError, match=r"t: 2 was given|t: 2.0 was given"):
        result.stress("beam").at(2.0)


@pytest.mark.parametrize("kind", list(MESHES)[:4])
def test_nodal_stress_by_scikit_fem_in_millimetres(kind: str) -> None:
    """Of any displacements in mm and moduli in MPa: strains, extrapolation and mean made again, element by element."""
    import skfem

    mesh, quadratic, triangles = MESHES[kind]().scaled(1e3), "quadratic" in kind, "triangles" in kind
    with pytest.warns(lf.ModelWarning, match="look like N, mm and t"):
        solid = solid_of(lf.Continuum(mesh, 7.8e-9, 2e5, NU))
    places = solid.mesh.places
    u = np.random.default_rng(3).normal(size=(len(places), 2))
    element = getattr(skfem, f"Element{'Tri' if triangles else 'Quad'}{'P' if triangles else ''}{1 + quadratic}")()
    points = 0.5 + np.array([[-1, 1, -1, 1], [-1, -1, 1, 1]]) / math.sqrt(12.0)
    if triangles:
        points = np.array([[1, 4, 1], [1, 1, 4]]) / 6.0 if quadratic else np.full((2, 1), 1 / 3)
    basis = skfem.Basis(mesh, element, quadrature=(points, np.ones(points.shape[1])))
    order = [int(np.hypot(*(places - at).T).argmin()) for at in basis.doflocs.T]
    H = np.stack([np.asarray(basis.interpolate(u[order, i]).grad) for i in range(2)])  # (2, 2, elements, points)
    strain = 0.5 * (H + H.swapaxes(0, 1))
    moduli = 2e5 / (1.0 - NU**2)
    xx, yy = (moduli * (strain[i, i] + NU * strain[1 - i, 1 - i]) for i in range(2))
    corners = element.doflocs
    terms = np.stack([np.ones(len(corners)), *corners.T, corners[:, 0] * corners[:, 1]])[: points.shape[1]]
    known = np.stack([np.ones(points.shape[1]), *points, points[0] * points[1]])[: points.shape[1]]
    found = nodal_stress(solid, nodal_gradients(solid), u[:, :, None])[:, :, 0]
    for part, sigma in ((0, xx), (1, yy), (2, moduli * (1.0 - NU) * strain[0, 1])):
        total, meet = np.zeros(len(places)), np.zeros(len(places))
        for e in range(mesh.t.shape[1]):
            nodes = [order[d] for d in basis.element_dofs[:, e]]
            total[nodes] += np.linalg.solve(known.T, sigma[e]) @ terms
            meet[nodes] += 1.0
        assert found[part] == pytest.approx(total / meet, abs=1e-11 * np.abs(xx).max())
