"""Painleve's rod: which motions the acceleration level admits, and what the event-driven stepper makes of them."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.dynamics.impact_laws import ImpactLaw, Newton, Poisson, Stronge
from lcpflex.solvers import ContactProblem, Enumeration
from lcpflex.steppers.several_motions import LOOKS, SeveralMotions
from lcpflex.studies.stability_maps.admissible_accelerations import ContactFate, Count, admissible_accelerations
from tests.scenes import floor_of


@pytest.mark.parametrize(
    ("mu", "degrees", "spin", "count", "forces"),
    [
        (0.5, 60.0, 0.0, Count.UNIQUE, [0.908694]),
        (1.4, 60.0, 0.0, Count.NONE, []),
        (1.4, 60.0, 1.2, Count.SEVERAL, [0.0, 3.598901]),
        (2.0, 30.0, 0.0, Count.UNIQUE, [1.533922]),
    ],
)
def test_statuses_of_the_rod(mu: float, degrees: float, spin: float, count: Count, forces: list[float]) -> None:
    found = admissible_accelerations(gallery.painleve_rod(mu, degrees, spin))
    assert found.count is count
    assert sorted(s.force[0, 0] for s in found.solutions) == pytest.approx(forces, abs=1e-6)
    for solution in found.solutions:
        expected = ContactFate.SEPARATES if solution.force[0, 0] == 0.0 else ContactFate.SLIDES_BACK
        assert solution.fate == (expected,)
        assert solution.force[0, 1] == pytest.approx(mu * solution.force[0, 0])  # against the slip to the left
        phi = math.radians(degrees)
        normal, tangential = solution.force[0]
        udot = [tangential, normal - 1.0, 3.0 * (math.sin(phi) * tangential - math.cos(phi) * normal)]
        assert solution.acceleration == pytest.approx(udot, abs=1e-12)


def test_both_sides_of_the_exact_boundary() -> None:
    for degrees in (30.0, 63.4349488, 80.0):
        boundary = gallery.painleve_friction(degrees)
        below = admissible_accelerations(gallery.painleve_rod(boundary * (1.0 - 1e-9), degrees))
        above = admissible_accelerations(gallery.painleve_rod(boundary * (1.0 + 1e-9), degrees))
        assert (below.count, above.count) == (Count.UNIQUE, Count.NONE)
    assert gallery.painleve_friction(math.degrees(math.atan(2.0))) == pytest.approx(4.0 / 3.0, abs=1e-14)
    assert min(gallery.painleve_friction(d) for d in np.linspace(1.0, 89.0, 9999)) >= 4.0 / 3.0


def test_redundant_supports_leave_forces_open_but_not_the_motion() -> None:
    scene = lf.Scene(gravity=(0.0, -9.81))
    shape = [(-0.2, -0.1), (0.0, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)]
    box = scene.add(lf.Polygon(shape, mass=1.0), name="box", position=(0.0, 0.1))
    scene.contact(box.surface(), floor_of(scene), name="floor")
    found = admissible_accelerations(scene)
    assert found.count is Count.UNIQUE
    assert not found.forces_unique
    assert found.contacts == ("floor",) * 3
    for solution in found.solutions:
        assert solution.force[:, 0].sum() == pytest.approx(9.81)
        assert solution.acceleration == pytest.approx(np.zeros(3), abs=1e-12)


def test_user_system_and_joints() -> None:
    """A mass on a floor under a push below and above its friction, given by M, h, g, W."""

    def block(push: float) -> lf.UserSystem:
        return lf.UserSystem(
            q=[0.0, 0.0],
            u=[0.0, 0.0],
            mass=2.0 * np.eye(2),
            force=lambda t, q, u: np.array([push, -10.0]),
            gaps=lambda q: q[1:],
            normals=[[0.0], [1.0]],
            tangents=[[1.0], [0.0]],
            friction=0.5,
            names=("floor",),
        )

    held, pushed = (admissible_accelerations(block(push)) for push in (4.0, 7.0))
    assert held.solutions[0].fate == (ContactFate.STICKS,)
    assert held.solutions[0].force == pytest.approx(np.array([[10.0, -4.0]]))
    assert pushed.solutions[0].fate == (ContactFate.SLIDES_FORTH,)
    assert pushed.solutions[0].acceleration == pytest.approx([1.0, 0.0])
    pendulum = gallery.double_pendulum()
    with pytest.raises(lf.ModelError, match=r"approaches at 0\.134202 m/s"):
        admissible_accelerations(pendulum)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(lf.ModelError, match="q: "):
        admissible_accelerations(gallery.painleve_rod(), q=[0.0])
    with pytest.raises(lf.ModelError, match="expected at most 16"):
        admissible_accelerations(gallery.stack(boxes=10))


def tip(rod: lf.Result) -> np.ndarray:
    return rod.velocity("rod", (-1.0, 0.0))


def rod_with(restitution: float, mu: float = 1.4) -> lf.Scene:
    """The rod of the paradox, with restitution."""
    angle = math.radians(60.0)
    scene = lf.Scene(gravity=(0.0, -1.0))
    rod = scene.add(
        lf.RigidBody(mass=1.0, inertia=1.0 / 3.0),
        name="rod",
        position=(math.cos(angle), math.sin(angle)),
        angle=angle,
        velocity=(-1.0, 0.0),
    )
    floor = floor_of(scene)
    scene.contact(rod.node(-1.0, 0.0), floor, friction=mu, restitution=restitution, name="floor")
    return scene


@pytest.mark.parametrize("law", [Newton(), Poisson(), Stronge(), Stronge(sequential=True)], ids=repr)
def test_impact_without_collision(law: ImpactLaw) -> None:
    """Without restitution all laws stop the tip: p = -G^-1 (gdot_T, 0), which costs 1/2 (G^-1)_TT = 0.21875 J."""
    result = lf.simulate(rod_with(0.0), 0.01, lf.EventDriven(impact=law), record=1e-3)
    first = result.events[0]
    assert (first.kind, first.time, first.contact) == ("impact without collision", 0.0, "floor")
    assert first.energy_change == pytest.approx(-0.21875, abs=1e-9)
    assert tip(result)[1] == pytest.approx([0.0, 0.0], abs=2e-6)
    assert [w for w in result.warnings if "Painleve" in w] == [
        "no acceleration was admissible (Painleve's paradox) once, first at t = 0 s: an impact without collision of "
        "contact 'floor' resolved it"
    ]


def test_restitution_of_an_impact_without_collision() -> None:
    """Newton has no approach to reflect; Poisson and Stronge give back what the jamming has compressed."""
    e = 0.5
    newton, poisson, stronge = (
        lf.simulate(rod_with(e), 0.01, lf.EventDriven(impact=law), record=1e-3)
        for law in (Newton(), Poisson(), Stronge())
    )
    assert abs(tip(newton)[1, 1]) < 2e-6
    gnn, gtt, gnt = 1.75, 3.25, 0.75 * math.sqrt(3.0)  # slip to the left: gdot_T < 0 pulls the tip in
    stuck = gnn - gnt**2 / gtt  # d gdot_N / dp in stick
    slipped = 1.0 / (1.4 * gtt - gnt)  # impulse that stops the slip of 1 m/s
    depth = (1.4 * gnt - gnn) * slipped  # approach by then
    compression = slipped + depth / stuck
    assert tip(poisson)[1, 1] == pytest.approx(e * compression * stuck, rel=1e-4)
    work = 0.5 * depth * compression
    assert tip(stronge)[1, 1] == pytest.approx(math.sqrt(2.0 * stuck * e**2 * work), abs=1e-9)


def test_choice_among_several_motions_is_told() -> None:
    result = lf.simulate(gallery.painleve_rod(1.4, 60.0, 1.2), 0.01, lf.EventDriven(), record=1e-3)
    assert [w for w in result.warnings if "Painleve" in w] == [
        "several motions were admissible (Painleve's paradox) once, first at t = 0 s: taken was the one in which "
        "contact 'floor' opens"
    ]


def test_runs_away_from_the_paradox_are_not_warned_of() -> None:
    for scene in (gallery.painleve_rod(0.5, 60.0), gallery.stack(boxes=2), gallery.spring_block()):
        result = lf.simulate(scene, 0.01, lf.EventDriven(), record=1e-3)
        assert not any("Painleve" in w for w in result.warnings)


def test_user_system_meets_the_paradox_in_the_python_loop() -> None:
    """The same rod by its own equations q = (x, y, phi) of the centre."""
    phi = math.radians(60.0)

    def rows(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        sin, cos = math.sin(q[2]), math.cos(q[2])
        return np.array([[0.0], [1.0], [-cos]]), np.array([[1.0], [0.0], [sin]])

    system = lf.UserSystem(
        q=[math.cos(phi), math.sin(phi), phi],
        u=[-1.0, 0.0, 0.0],
        mass=np.diag([1.0, 1.0, 1.0 / 3.0]),
        force=lambda t, q, u: np.array([0.0, -1.0, 0.0]),
        gaps=lambda q: np.array([q[1] - math.sin(q[2])]),
        normals=lambda q: rows(q)[0],
        tangents=lambda q: rows(q)[1],
        friction=1.4,
        names=("tip",),
    )
    assert admissible_accelerations(system).count is Count.NONE
    result = lf.simulate(system, 0.01, lf.EventDriven(), record=1e-3)
    assert result.events[0].kind == "impact without collision"
    assert any("contact 'tip' resolved it" in w for w in result.warnings)


def test_problems_of_one_kind_are_looked_at_some_times(monkeypatch):
    """Contacts that come to rest flicker between kinds: each look tries all active sets, and linear programs."""
    looks = []

    class Counted(Enumeration):
        def solve(self, problem, guess=None):
            if isinstance(problem, ContactProblem):  # which is then posed as an LCP
                looks.append(problem)
            return super().solve(problem, guess)

    monkeypatch.setattr("lcpflex.steppers.several_motions.Enumeration", Counted)
    several = SeveralMotions()

    def work(free):
        values = [0.0, 1, 2, 0, 0.5, free, 0.1, 1.0, 0.4, 0.4, 1.0, -free, 0.0]  # t, n, m, law, mu, free, G, forces
        return SimpleNamespace(impulses=SimpleNamespace(doubtful=[np.array(values)], n_doubtful=1))

    for _ in range(3 * LOOKS):
        assert not several.remarks(work(-1.0), str)
    assert len(looks) == LOOKS
    several.remarks(work(1.0), str)
    assert len(looks) == LOOKS + 1  # of another kind
