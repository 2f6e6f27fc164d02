"""Laws of impact on the event-driven stepper: published numbers, closed forms, and what no law may do."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.dynamics.impact_laws import SEGMENTS, ImpactLaw, Newton, Poisson, Stronge, energetic_segments
from tests.scenes import floor_of

LAWS = (Newton(), Poisson(), Stronge(), Newton(sequential=True), Poisson(sequential=True), Stronge(sequential=True))
NAMES = [repr(law) for law in LAWS]


class Delegate:
    """Lemke's method behind an object that is not known to be compiled: the loop is Python's."""

    def solve(self, problem: lf.solvers.Lcp, guess: object = None) -> lf.solvers.Solution:
        return lf.Lemke().solve(problem)


def struck(scene: lf.Scene, law: ImpactLaw, duration: float = 1e-3, **options: object) -> lf.Result:
    return lf.simulate(scene, duration, lf.EventDriven(impact=law, **options), record=duration)


def kinetic_change(result: lf.Result) -> float:
    """Of the impacts at the start."""
    return float(result.energies.kinetic[1] - result.energies.kinetic[0])


@pytest.mark.parametrize(
    ("law", "rates", "change"),
    [(Newton(), (-0.334649, 0.363115), 0.5875), (Poisson(), (-0.196055, 0.212732), -0.4551)],
    ids=["Newton", "Poisson"],
)
def test_kanes_double_pendulum(law: ImpactLaw, rates: tuple[float, float], change: float) -> None:
    result = struck(gallery.double_pendulum(), law)
    assert result.times[1] == 0.0
    assert result.u[1, [2, 5]] == pytest.approx(rates, abs=1e-6)
    before = result.energies.kinetic[0]
    assert before == pytest.approx(0.02318141, abs=1e-8)
    assert kinetic_change(result) / before == pytest.approx(change, abs=1e-4)
    assert sum(e.energy_change for e in result.events if e.kind == "impact") == pytest.approx(
        kinetic_change(result), abs=1e-14
    )
    assert any("created energy" in w for w in result.warnings) == (change > 0.0)
    if isinstance(law, Newton):
        assert result.impulse[1, 0] == pytest.approx([0.567980, -0.244597], abs=1e-6)


def test_energetic_law_on_kanes_pendulum() -> None:
    """The work of the normal impulse is -e^2 of that of compression; slip stops and the tip sticks on the way."""
    result = struck(gallery.double_pendulum(), Stronge())
    elastic = struck(gallery.double_pendulum(restitution=0.0), Stronge())
    compression = elastic.energies.impact[1]
    assert result.energies.impact[1] == pytest.approx(0.75 * compression, rel=1e-12)
    assert -result.energies.kinetic[0] < kinetic_change(result) < 0.0
    tip = result.velocity("lower rod", (1.0, 0.0))[1]
    assert tip[1] > 0.0
    assert sum(e.energy_change for e in result.events if e.kind == "impact") == pytest.approx(
        kinetic_change(result), abs=1e-14
    )


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_oblique_bounce(law: ImpactLaw) -> None:
    """Normal and tangential motion of a disc do not influence each other, and it slips throughout: one answer."""
    result = lf.simulate(gallery.oblique_bounce(), 0.5, lf.EventDriven(impact=law))
    assert result.impulse[-1, 0] == pytest.approx([3.4, -0.68], abs=1e-12)
    assert result.u[-1] == pytest.approx([2.32, 1.4, -1.7], abs=1e-12)


@pytest.mark.parametrize(
    ("law", "speeds"),
    [
        (Newton(), (-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0)),
        (Poisson(), (-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0)),
        (Newton(sequential=True), (0.0, 0.0, 1.0)),
        (Poisson(sequential=True), (0.0, 0.0, 1.0)),
        (Stronge(sequential=True), (0.0, 0.0, 1.0)),
    ],
    ids=repr,
)
def test_three_balls_in_a_row(law: ImpactLaw, speeds: tuple[float, ...]) -> None:
    """Poisson: compression leaves 1/3 each, by the impulses 2/3 and 1/3, which expansion lays once more."""
    result = lf.simulate(gallery.three_balls(), 0.1, lf.EventDriven(impact=law))
    assert result.u[-1, [0, 3, 6]] == pytest.approx(speeds, abs=1e-12)
    hits = [e for e in result.events if e.kind == "impact"]
    assert [e.contact for e in hits] == ["first", "second"]
    assert sum(e.energy_change for e in hits) == pytest.approx(
        result.energies.kinetic[-1] - result.energies.kinetic[0], abs=1e-14
    )


def test_energetic_law_refuses_contacts_that_close_together() -> None:
    with pytest.raises(lf.StepError, match=r"contacts first, second: .*sequential=True\), Poisson\(\) or Newton\(\)"):
        struck(gallery.three_balls(), Stronge())


def test_energetic_law_takes_independent_contacts_at_once() -> None:
    """Two balls reach the floor at the same time: they do not influence each other."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    floor = floor_of(scene)
    for k in range(2):
        ball = scene.add(
            lf.Disc(radius=0.1, mass=1.0), name=f"ball {k}", position=(float(k), 0.2), velocity=(0.0, -1.0)
        )
        scene.contact(ball.surface(), floor, restitution=0.5 + 0.2 * k, name=f"floor {k}")
    result = struck(scene, Stronge(), 0.2)
    assert result.u[-1, [1, 4]] == pytest.approx([0.5, 0.7], abs=1e-12)


@pytest.mark.parametrize("law", LAWS, ids=NAMES)
def test_python_loop_strikes_alike(law: ImpactLaw) -> None:
    """The same source with its loop in Python, for solvers, callbacks and systems given by functions."""
    compiled = struck(gallery.double_pendulum(), law)
    python = struck(gallery.double_pendulum(), law, solver=Delegate())
    assert python.u[1] == pytest.approx(compiled.u[1], abs=1e-12)
    assert python.impulse[1] == pytest.approx(compiled.impulse[1], abs=1e-12)


@pytest.mark.parametrize("solver", [lf.solvers.GaussSeidel(), lf.solvers.Enumeration()], ids=repr)
def test_other_solvers_see_the_shift_of_the_expansion(solver: lf.solvers.LcpSolver) -> None:
    """Their contact problems have no place for p_N >= e p_C: the expansion comes to them as a plain LCP."""
    result = struck(gallery.double_pendulum(), Poisson(), solver=solver)
    assert result.u[1, [2, 5]] == pytest.approx([-0.196055, 0.212732], abs=1e-6)


@pytest.mark.parametrize("law", [Poisson(), Stronge()], ids=repr)
def test_laws_agree_without_friction(law: ImpactLaw) -> None:
    for e in (0.0, 0.3, 1.0):
        newton = struck(gallery.double_pendulum(0.0, e), Newton())
        other = struck(gallery.double_pendulum(0.0, e), law)
        assert other.u[1] == pytest.approx(newton.u[1], abs=1e-12)


def random_rod(rng: np.random.Generator) -> lf.Scene:
    """A rod of random shape strikes a rough floor with one end."""
    angle = rng.uniform(0.1, math.pi - 0.1)
    scene = lf.Scene(gravity=(0.0, 0.0))
    rod = scene.add(
        lf.RigidBody(mass=1.0, inertia=rng.uniform(0.05, 1.0)),
        name="rod",
        position=(math.cos(angle), math.sin(angle)),
        angle=angle,
        velocity=(rng.uniform(-2.0, 2.0), -1.0),
        angular_velocity=rng.uniform(-0.5, 0.5),
    )
    floor = floor_of(scene)
    scene.contact(rod.node(-1.0, 0.0), floor, friction=rng.uniform(0.0, 3.0), restitution=rng.uniform(0.0, 1.0))
    return scene


def random_pendulum(rng: np.random.Generator) -> lf.Scene:
    """Two hinged rods of random masses, angles and rates, the tip on its way into a rough floor."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    place, speed, bodies = np.zeros(2), np.zeros(2), []
    for k in range(2):
        mass, angle, rate = rng.uniform(0.3, 3.0), rng.uniform(-math.pi, math.pi), rng.uniform(-2.0, 2.0)
        rod = lf.RigidBody(
            mass=mass, inertia=mass / 12.0, center=(0.5, 0.0), points={"top": (0.0, 0.0), "bottom": (1.0, 0.0)}
        )
        bodies.append(
            scene.add(rod, name=f"rod {k}", position=place, angle=angle, velocity=speed, angular_velocity=rate)
        )
        along = np.array([math.cos(angle), math.sin(angle)])
        place = place + along
        speed = speed + rate * np.array([-along[1], along[0]])
    scene.join(lf.Revolute(bodies[0].point("top"), scene.ground.at(0.0, 0.0)))
    scene.join(lf.Revolute(bodies[1].point("top"), bodies[0].point("bottom")))
    turn = rng.uniform(-1.4, 1.4)  # of the floor, against which the tip moves
    normal = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]) @ -speed
    floor = scene.ground.half_plane(tuple(place), tuple(normal))
    friction, restitution = rng.uniform(0.0, 2.0), rng.uniform(0.0, 1.0)
    scene.contact(bodies[1].node(1.0, 0.0), floor, friction=friction, restitution=restitution, name="floor")
    return scene


def test_energetic_law_makes_no_energy_in_random_pendulums_where_newtons_does() -> None:
    rng = np.random.default_rng(11)
    grown = 0
    for _ in range(60):
        scene = random_pendulum(rng)
        by_newton = struck(scene, Newton(), 1e-5)
        scale = by_newton.energies.kinetic[0]
        grown += kinetic_change(by_newton) > 1e-6 * scale
        result = struck(scene, Stronge(), 1e-5)
        assert result.impulse[1, 0, 0] > 0.0
        assert kinetic_change(result) <= 1e-13 * scale
    assert grown > 0  # the cases are of those where the law matters


@pytest.mark.parametrize("law", [Poisson(), Stronge()], ids=repr)
def test_no_energy_from_random_rods(law: ImpactLaw) -> None:
    rng = np.random.default_rng(5)
    fell = 0
    for _ in range(40):
        result = struck(random_rod(rng), law, 1e-4)
        change = kinetic_change(result)
        if isinstance(law, Stronge):
            assert change <= 1e-13
        fell += change < -1e-3
        tip = result.velocity("rod", (-1.0, 0.0))[1]
        assert tip[1] >= -1e-9
        assert result.impulse[1, 0, 0] > 0.0
        assert change == pytest.approx(sum(e.energy_change for e in result.events[:1]), abs=1e-12)
    assert fell > 30


def test_energetic_impulses_of_random_contacts() -> None:
    """Passive, never approaching at the end, inside the cone, the work of restitution e^2 that of compression."""
    rng = np.random.default_rng(3)
    phases = set()
    for _ in range(2000):
        root = rng.normal(size=(2, 2))
        G = root @ root.T + 1e-3 * np.eye(2)
        v = np.array([-rng.uniform(0.1, 1.0), rng.uniform(-2.0, 2.0)])
        mu, e = rng.uniform(0.0, 3.0), rng.uniform(0.0, 1.0)
        segments = np.zeros((SEGMENTS, 2))
        count = energetic_segments(G[0, 0], G[0, 1], G[1, 1], v[0], v[1], mu, e, segments)
        assert 0 < count <= 4
        phases.add(count)
        after, taken, given = v.copy(), 0.0, 0.0
        for p in segments[:count]:
            assert abs(p[1]) <= mu * p[0] * (1.0 + 1e-12)
            mean = after + 0.5 * G @ p
            rounding = 1e-14 * (1.0 + (np.abs(G) @ np.abs(p)).max()) * np.abs(p).max()
            assert mean[1] * p[1] <= rounding  # friction never drives
            if mean[0] < 0.0:
                taken -= mean[0] * p[0]
            else:
                given += mean[0] * p[0]
            after = after + G @ p
        assert after[0] >= -1e-12
        assert given == pytest.approx(e**2 * taken, abs=1e-10 * max(1.0, taken))
    assert phases >= {2, 3}


def test_slow_approach_ends_all_laws() -> None:
    """Below the velocity threshold nothing is reflected: the ball rests where its bounces accumulate."""
    for law in (Poisson(), Stronge(), Newton(sequential=True)):
        result = lf.simulate(gallery.bouncing_ball(), 1.6, lf.EventDriven(impact=law))
        rest = next(e.time for e in result.events if e.kind == "touch-down")
        assert rest == pytest.approx(3.0 * math.sqrt(2.0 / 9.81), abs=5e-7)


def struck_from_both_sides(first: str, speeds: tuple[float, float], apart: float = 0.2) -> lf.Scene:
    """A ball at rest between two that arrive at the same time; the contact to the ``first`` is declared first."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    middle = scene.add(lf.Disc(radius=0.1, mass=1.0), name="middle")
    balls = {
        side: scene.add(
            lf.Disc(radius=0.1, mass=1.0), name=side, position=(apart * sign, 0.0), velocity=(-sign * speed, 0.0)
        )
        for side, sign, speed in (("left", -1.0, speeds[0]), ("right", 1.0, speeds[1]))
    }
    for side in sorted(balls, reverse=first == "right"):
        scene.contact(balls[side].surface(), middle.surface(), restitution=0.5, name=side)
    return scene


@pytest.mark.parametrize("law", [Newton(sequential=True), Poisson(sequential=True), Stronge(sequential=True)])
def test_arbitrary_order_of_impacts_is_told(law: ImpactLaw) -> None:
    """The middle ball is struck on both sides at the same time: who strikes first leaves another motion."""
    ends = []
    for first, second in (("left", "right"), ("right", "left")):
        result = struck(struck_from_both_sides(first, (1.0, 1.0), 0.3), law, 0.2)
        assert [w for w in result.warnings if "order" in w] == [
            f"the order of impacts was arbitrary once, first at t = 0.1 s: contacts {first!r} and {second!r} "
            "approached equally fast; another order may lead to another motion"
        ]
        ends.append(result.u[-1, [3, 0, 6]])
    assert ends[0] == pytest.approx(-ends[1][::-1], abs=1e-12)  # the mirror image
    assert abs(ends[0] - ends[1]).max() == pytest.approx(0.09375, abs=1e-12)


def test_order_of_impacts_is_no_matter_where_one_is_faster_or_nothing_is_shared() -> None:
    faster = struck(struck_from_both_sides("left", (1.0, 1.001)), Newton(sequential=True), 0.01)
    assert not any("order" in w for w in faster.warnings)
    scene = lf.Scene(gravity=(0.0, 0.0))
    floor = floor_of(scene)
    for k in range(2):
        ball = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(float(k), 0.2), velocity=(0.0, -1.0))
        scene.contact(ball.surface(), floor, restitution=0.5)
    apart = struck(scene, Newton(sequential=True), 0.2)
    assert len(apart.events) == 2
    assert not any("order" in w for w in apart.warnings)


def test_tangential_restitution_is_newtons() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(radius=0.1, mass=1.0), name="disc", position=(0.0, 0.2), velocity=(1.0, -1.0))
    floor = floor_of(scene)
    scene.contact(disc.surface(), floor, friction=0.3, restitution=0.5, tangential_restitution=0.5)
    for law in (Poisson(), Stronge()):
        with pytest.raises(lf.ModelError, match="tangential restitution"):
            struck(scene, law)


def test_bad_laws_are_refused() -> None:
    with pytest.raises(lf.ModelError, match="impact: "):
        lf.EventDriven(impact="Newton")  # type: ignore[arg-type]
    with pytest.raises(lf.ModelError, match="sequential"):
        Newton(sequential=2)  # type: ignore[arg-type]
