"""Events that come together, follow without end, start at once, or end where a surface does."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lcpflex as lf
from lcpflex import gallery
from lcpflex.dynamics.impact_laws import ImpactLaw, Newton, Poisson, Stronge
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.jit.kernel import FloatArray
from tests.scenes import floor_of

G = 9.81
SHARP: dict[str, Any] = {"rtol": 1e-11, "atol": 1e-13}


def times(result: lf.Result, kind: str, contact: str | None = None) -> list[float]:
    return [e.time for e in result.events if e.kind == kind and contact in (None, e.contact)]


def sliding_block(scene: lf.Scene, name: str, x: float, speed: float, friction: float) -> Any:
    block = scene.add(lf.Box(width=0.4, height=0.2, mass=1.0), name=name, position=(x, 0.1), velocity=(speed, 0.0))
    scene.contact(block.surface(), floor_of(scene), friction=friction, name=f"under {name}")
    return block


def test_slips_of_two_blocks_stop_at_the_same_time() -> None:
    """Mirrored blocks: two contacts change at one event, and both are told."""
    scene = lf.Scene(gravity=(0.0, -G))
    sliding_block(scene, "left", -5.0, -1.0, 0.3)
    sliding_block(scene, "right", 5.0, 1.0, 0.3)
    result = lf.simulate(scene, 0.5, lf.EventDriven())
    stop = 1.0 / (0.3 * G)
    assert times(result, "stick", "under left") == pytest.approx([stop], abs=1e-11)
    assert times(result, "stick", "under right") == times(result, "stick", "under left")
    assert len(result.events) == 2
    assert result.q[-1, [0, 3]] == pytest.approx([-5.0 - 0.5 * stop, 5.0 + 0.5 * stop], abs=1e-11)


@pytest.mark.parametrize("early", [-1e-13, 0.0, 1e-13])
def test_ball_lands_at_the_very_time_a_slip_stops(early: float) -> None:
    """To rounding: whichever root comes first, both events happen and neither spoils the other."""
    stop = 1.0 / (0.3 * G)
    scene = lf.Scene(gravity=(0.0, -G))
    sliding_block(scene, "block", 0.0, 1.0, 0.3)
    height = 0.5 * G * (stop - early) ** 2
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), name="ball", position=(5.0, 0.1 + height))
    scene.contact(ball.surface(), floor_of(scene), restitution=0.5, name="under ball")
    result = lf.simulate(scene, 0.6, lf.EventDriven())
    assert times(result, "stick") == pytest.approx([stop], abs=1e-11)
    assert times(result, "impact")[0] == pytest.approx(stop, abs=1e-11)
    assert result.q[-1, 0] == pytest.approx(0.5 * stop, abs=1e-11)
    rest = 0.6 - stop
    assert result.q[-1, 4] == pytest.approx(0.1 + 0.5 * G * stop * rest - 0.5 * G * rest**2, abs=1e-10)


def test_ball_lands_on_a_block_as_its_slip_stops() -> None:
    """The impact stops the slip: it acts through the sliding contact, whose friction is Coulomb's in impulses, too."""
    stop = 1.0 / (0.3 * G)
    before = stop - 0.02
    scene = lf.Scene(gravity=(0.0, -G))
    block = sliding_block(scene, "block", 0.0, 1.0, 0.3)
    x = before - 0.15 * G * before**2
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), name="ball", position=(x, 0.3 + 0.5 * G * before**2))
    scene.contact(ball.surface(), block.surface(), name="on block")
    result = lf.simulate(scene, 0.5, lf.EventDriven(), record=0.01)
    hit = times(result, "impact", "on block")
    assert hit == pytest.approx([before], abs=1e-10)
    assert times(result, "impact", "under block") == hit
    slow = 1.0 - 0.3 * G * before  # less than mu v_ball: the impulse of the impact stops the block
    assert slow < 0.3 * G * before
    after = result.times >= before
    assert np.abs(result.u[after][1:, :2]).max() < 1e-9
    assert result.force[-1].max() == pytest.approx(2.0 * G, abs=1e-8)


@pytest.mark.parametrize("restitution", [pytest.param(0.0, marks=pytest.mark.slow), 0.3])
def test_chatter_on_a_shaken_table(restitution: float) -> None:
    """A ball leaves where the table falls faster than g, lands, chatters to rest, and leaves a period later."""
    amplitude, omega = 0.01, 40.0
    leave = math.asin(G / (amplitude * omega**2)) / omega
    period = 2.0 * math.pi / omega

    def table(t: float) -> float:
        return amplitude * math.sin(omega * t)

    system = lf.UserSystem(
        q=[0.0, 0.0],
        u=[amplitude * omega, amplitude * omega],
        mass=np.eye(2),
        force=lambda t, q, u: np.array([-G, 0.0]),
        gaps=lambda q: q[:1] - q[1:],
        normals=[[1.0], [-1.0]],
        restitution=restitution,
        names=("table",),
        constraints=lambda t, q: q[1:] - table(t),
        jacobian=lambda t, q: np.array([[0.0, 1.0]]),
        constraint_rate=lambda t, q: np.array([-amplitude * omega * math.cos(omega * t)]),
        constraint_bias=lambda t, q, u: np.array([amplitude * omega**2 * math.sin(omega * t)]),
    )
    result = lf.simulate(system, 2.3 * period, lf.EventDriven(**SHARP), record=0.01)
    assert times(result, "lift-off") == pytest.approx([leave + k * period for k in range(3)], abs=1e-9)
    landed = times(result, "touch-down")
    assert len(landed) == 2
    assert len(times(result, "impact")) == 2 if restitution == 0.0 else len(times(result, "impact")) > 10
    flight = times(result, "impact")[0] - leave
    speed = amplitude * omega * math.cos(omega * leave)
    fallen = table(leave) + speed * flight - 0.5 * G * flight**2
    assert fallen == pytest.approx(table(leave + flight), abs=1e-12)


@pytest.mark.parametrize("e", [0.5, 0.9])
def test_bounces_accumulate(e: float) -> None:
    first = math.sqrt(2.0 / G)
    result = lf.simulate(gallery.bouncing_ball(restitution=e), first * (1.0 + e) / (1.0 - e) + 0.1, lf.EventDriven())
    assert times(result, "touch-down") == pytest.approx([first * (1.0 + e) / (1.0 - e)], abs=3e-6 / (1.0 - e))
    hits = times(result, "impact")
    expected = [first * (1.0 + 2.0 * e * (1.0 - e**n) / (1.0 - e)) for n in range(len(hits))]
    speed = math.sqrt(2.0 * G) * e ** np.arange(1, len(hits) + 1)
    rounding = 1e-12 + np.cumsum(4e-14 / speed)  # heights of a metre are known to 1e-14 m
    assert (np.abs(np.array(hits) - expected) <= rounding).all()
    assert rounding[len(hits) // 2] < 1e-9
    assert np.abs(result.u[-1]).max() < 1e-12


@pytest.mark.parametrize("law", [Newton(sequential=True), Poisson(sequential=True), Stronge(sequential=True)])
def test_contact_is_hit_twice_within_an_event(law: ImpactLaw) -> None:
    """A ball hits another that touches a wall: ball, wall, ball again, and the first one flies back as fast."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    first, second = (
        scene.add(lf.Disc(radius=0.1, mass=1.0), name=f"ball {k}", position=(0.2 * k, 0.0), velocity=(1.0 - k, 0.0))
        for k in range(2)
    )
    wall = scene.ground.half_plane((0.3, 0.0), (-1.0, 0.0))
    scene.contact(first.surface(), second.surface(), restitution=1.0, name="balls")
    scene.contact(second.surface(), wall, restitution=1.0, name="wall")
    result = lf.simulate(scene, 0.1, lf.EventDriven(impact=law))
    assert result.u[-1, [0, 3]] == pytest.approx([-1.0, 0.0], abs=1e-12)
    assert result.impulse[-1, :, 0] == pytest.approx([2.0, 2.0], abs=1e-12)
    assert [(e.kind, e.time) for e in result.events] == [("impact", 0.0)] * 2


def test_endless_chain_is_cut_and_told() -> None:
    """Two balls pressed between walls by their own speeds at e = 1 would hit for ever at one instant."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), name="ball", velocity=(1.0, 0.0))
    for name, x in (("left", -0.1), ("right", 0.1)):
        wall = scene.ground.half_plane((x, 0.0), (-math.copysign(1.0, x), 0.0))
        scene.contact(ball.surface(), wall, restitution=1.0, name=name)
    result = lf.simulate(scene, 0.01, lf.EventDriven(impact=Newton(sequential=True)))
    assert any("did not end by itself once" in w for w in result.warnings)
    assert result.u[-1] == pytest.approx(np.zeros(3), abs=1e-12)


@pytest.mark.parametrize("depth", [1e-3, 1e-6, 1e-8])
def test_graze_between_two_looks_is_an_impact(depth: float) -> None:
    """A disc flies past another one and overlaps by so little, or so fast, that it does at none of the samples."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(radius=0.1, mass=1.0), name="disc", position=(-1.0, 0.2 - depth), velocity=(1.0, 0.0))
    scene.contact(disc.surface(), scene.ground.circle((0.0, 0.0), 0.1), restitution=0.5, name="graze")
    result = lf.simulate(scene, 2.0, lf.EventDriven())
    cosine = 1.0 - depth / 0.2
    sine = math.sqrt(1.0 - cosine**2)
    assert times(result, "impact") == pytest.approx([1.0 - 0.2 * sine], abs=1e-6 * sine)
    assert result.u[-1, :2] == pytest.approx([1.0 - 1.5 * sine**2, 1.5 * sine * cosine], abs=1e-6 * sine)


@pytest.mark.parametrize("part", [1e-3, 1e-6, 1e-8])
def test_throw_that_just_reaches_the_ceiling(part: float) -> None:
    speed = math.sqrt(2.0 * G * 0.5) * (1.0 + part)
    scene = lf.Scene(gravity=(0.0, -G))
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), name="ball", velocity=(0.0, speed))
    scene.contact(ball.surface(), scene.ground.half_plane((0.0, 0.6), (0.0, -1.0)), restitution=0.5, name="ceiling")
    result = lf.simulate(scene, 0.6, lf.EventDriven())
    left = math.sqrt(speed**2 - G)
    assert times(result, "impact") == pytest.approx([(speed - left) / G], abs=1e-7 * left)
    assert result.u[-1, 1] == pytest.approx(speed - 1.5 * left - 0.6 * G, abs=1e-6 * left)


@pytest.mark.parametrize("height", [0.03, 0.05, 0.08, 0.11, 0.15])
def test_corner_does_not_pass_through_a_thin_plate_between_two_looks(height: float) -> None:
    """Wherever the looks fall: half through, the corner is nearer to the far side, which does not face it."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    plate = scene.add(lf.Box(width=0.3, height=0.02, mass=1.0), name="plate")
    box = scene.add(
        lf.Box(width=0.1, height=0.1, mass=1.0),
        name="box",
        position=(0.0, 0.01 + height + math.hypot(0.05, 0.05)),
        angle=0.25 * math.pi,
        velocity=(0.0, -5.0),
    )
    scene.contact(box.surface(), plate.surface(), restitution=1.0, name="plate")
    result = lf.simulate(scene, 0.2, lf.EventDriven())
    assert times(result, "impact") == pytest.approx([height / 5.0], abs=1e-9)
    assert result.u[-1, [1, 4]] == pytest.approx([-5.0, 0.0], abs=1e-9)
    assert result.warnings == ()


def test_small_initial_penetration_is_no_event() -> None:
    scene = lf.Scene(gravity=(0.0, -G))
    box = scene.add(lf.Box(width=0.4, height=0.2, mass=1.0), name="box", position=(0.0, 0.1 - 1e-7))
    scene.contact(box.surface(), floor_of(scene), friction=0.3, restitution=0.8, name="floor")
    result = lf.simulate(scene, 0.1, lf.EventDriven())
    assert not result.events
    assert result.q[-1] == pytest.approx([0.0, 0.1, 0.0], abs=1e-12)
    assert np.abs(result.u).max() < 1e-12
    assert result.force[-1, 0, 0] == pytest.approx(G, abs=1e-9)


@pytest.mark.parametrize("gap", [0.0, 1e-17, -1e-17, 5e-10])
def test_start_touching_and_approaching(gap: float) -> None:
    """No time passes before the impact; it is stored before and after."""
    scene = lf.Scene(gravity=(0.0, -G))
    ball = scene.add(lf.Disc(radius=0.5, mass=1.0), name="ball", position=(0.0, 0.5 + gap), velocity=(0.0, -1.0))
    scene.contact(ball.surface(), floor_of(scene), restitution=0.5, name="floor")
    result = lf.simulate(scene, 0.05, lf.EventDriven())
    assert times(result, "impact") == [0.0]
    assert result.times[:2].tolist() == [0.0, 0.0]
    assert result.u[:2, 1] == pytest.approx([-1.0, 0.5], abs=1e-12)
    assert result.q[-1, 1] == pytest.approx(0.5 + 0.5 * 0.05 - 0.5 * G * 0.05**2, abs=1e-8)


def test_foot_leaves_the_end_of_a_rolling_arc() -> None:
    """A rocker on an arc of 1.2 rad rolls at 2 rad/s: after .3 s its end is under the centre, and it tips over that.

    It is an inverted pendulum then, of I = .1 + .25 kg m^2 about the end: I theta'' = m g r sin theta.
    """
    scene = lf.Scene(gravity=(0.0, -G))
    rocker = scene.add(
        lf.RigidBody(mass=1.0, inertia=0.1), name="rocker", position=(0.0, 0.5), velocity=(1.0, 0.0),
        angular_velocity=-2.0,
    )  # fmt: skip
    rim = rocker.arc((0.0, 0.0), 0.5, -0.5 * math.pi - 0.6, 1.2)
    scene.contact(rim, floor_of(scene), friction=0.5, name="floor")
    result = lf.simulate(scene, 0.4, lf.EventDriven())
    assert times(result, "lift-off") == []
    theta = solve_ivp(lambda t, y: [y[1], G * 0.5 / 0.35 * math.sin(y[0])], (0.0, 0.1), [0.0, 2.0], rtol=1e-12).y[0, -1]
    assert result.q[-1] == pytest.approx([0.3 + 0.5 * math.sin(theta), 0.5 * math.cos(theta), -0.6 - theta], abs=1e-8)


def test_hinged_rods_in_flight_keep_their_momenta() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    rod = lf.RigidBody(mass=2.0, inertia=0.3, points={"left": (-0.5, 0.0), "right": (0.5, 0.0)})
    one = scene.add(rod, name="one", velocity=(0.3, -0.2), angular_velocity=2.0)
    two = scene.add(
        rod, name="two", position=(0.5, 0.5), angle=0.5 * math.pi, velocity=(-0.2, 0.8), angular_velocity=-1.0
    )
    scene.join(lf.Revolute(one.point("right"), two.point("left")))
    result = lf.simulate(scene, 5.0, lf.EventDriven(**SHARP), record=0.1, project=True)
    x, v = (np.stack([a[:, :3], a[:, 3:6]]) for a in (result.q, result.u))
    linear = 2.0 * v[:, :, :2].sum(axis=0)
    angular = (2.0 * (x[..., 0] * v[..., 1] - x[..., 1] * v[..., 0]) + 0.3 * v[..., 2]).sum(axis=0)
    assert np.abs(linear - linear[0]).max() < 1e-12
    assert np.abs(angular - angular[0]).max() < 5e-12
    assert np.ptp(v[0, :, 2]) > 0.2  # the hinge works
    assert result.joint_drift.max() < 1e-10
    assert np.ptp(result.energies.kinetic) < 1e-10


def test_spinning_beam_in_flight_keeps_its_momenta() -> None:
    modes = 4
    rate = np.zeros(modes)
    rate[:3] = (0.3, -0.2, 0.1)
    beam = lf.Beam(1.0, 0.05, 0.02, density=1000.0, youngs_modulus=1e8).reduce(modes=modes)
    scene = lf.Scene(gravity=(0.0, 0.0))
    scene.add(beam, velocity=(0.4, -0.1), angular_velocity=6.0, modal_velocity=rate)
    result = lf.simulate(scene, 0.2, lf.EventDriven(**SHARP), record=0.01)
    model = scene.compiled().model

    def momenta(q: FloatArray, u: FloatArray) -> FloatArray:
        motions = np.zeros((3, len(q)))
        motions[0, 0] = motions[1, 1] = motions[2, 2] = 1.0
        motions[2, :2] = (-q[1], q[0])
        return np.asarray(motions @ mass_matrix(model, q) @ u)

    all_momenta = np.array([momenta(q, u) for q, u in zip(result.q, result.u, strict=True)])
    assert np.abs(all_momenta - all_momenta[0]).max() < 1e-11
    assert np.ptp(result.u[:, 2]) > 1e-3  # modes and rotation exchange momentum
    assert np.ptp(result.energies.stored) < 1e-9 * result.energies.stored[0]


def heap(seed: int) -> lf.Scene:
    """Discs and boxes fall into a trough."""
    generator = np.random.default_rng(seed)
    scene = lf.Scene(gravity=(0.0, -G))
    for point, normal in (((0.0, 0.0), (0.0, 1.0)), ((-0.6, 0.0), (1.0, 0.0)), ((0.6, 0.0), (-1.0, 0.0))):
        scene.ground.half_plane(point, normal)
    for k in range(5):
        scene.add(
            lf.Box(width=0.2, height=0.1, mass=1.0) if k % 2 else lf.Disc(radius=0.08, mass=1.0),
            name=f"body {k}",
            position=(generator.uniform(-0.3, 0.3), 0.2 + 0.25 * k),
            angle=generator.uniform(-1.0, 1.0),
            velocity=generator.uniform(-1.0, 1.0, 2),
        )
    scene.contact_all(friction=0.4, restitution=0.3)
    return scene


@pytest.mark.parametrize(
    "law", [Poisson(), Newton(sequential=True), Poisson(sequential=True), Stronge(sequential=True)], ids=repr
)
@pytest.mark.parametrize("seed", [4, 8])
def test_heap_keeps_its_laws_under_all_laws_of_impact(law: ImpactLaw, seed: int) -> None:
    """Hundreds of impacts, many of several contacts: no penetration, no energy from nowhere, few idle events.

    Contacts that approached slower than the velocity threshold, and were let go, closed every microsecond.
    """
    result = lf.simulate(heap(seed), 2.0, lf.EventDriven(impact=law), record=0.01)
    assert len(times(result, "impact")) > 100
    assert result.steps < 2000
    assert np.nanmin(result.gap) > -1e-8
    assert result.energies.relative_remainder < 1e-7
    assert np.diff(result.energies.friction + result.energies.impact).min() > -1e-8
    assert result.contact_points.force[:, 0].min() > -1e-6


def test_woodpecker_pecks_as_published() -> None:
    result = lf.simulate(gallery.woodpecker(), 0.4, lf.EventDriven(), record=1e-3)
    pecks = times(result, "impact", "beak")
    assert pecks == pytest.approx([0.08102, 0.2269, 0.3730], abs=1e-4)
    height = np.interp(pecks, result.times, result.q[:, 0])
    assert 0.5 * (height[2] - height[0]) == pytest.approx(-19.4e-3, abs=1e-4)  # a cycle, of the first two


def flat_bounces(**options: Any) -> lf.Result:
    scene = lf.Scene(gravity=(0.0, -G))
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), name="ball", position=(0.0, 0.1), velocity=(0.0, 2e-5))
    scene.contact(ball.surface(), floor_of(scene), restitution=1.0, name="floor")
    return lf.simulate(scene, 0.01, lf.EventDriven(**options), record=0.01)


def test_too_many_events_end_the_run() -> None:
    """A ball that bounces 245 250 times a second for ever; the rate is that of a thousand events."""
    with pytest.raises(lf.StepError, match=r"'floor'.*more than 100000 a second.*MoreauJean") as caught:
        flat_bounces(most_events=1e5)
    assert caught.value.time == pytest.approx(1001 * 4e-5 / G, rel=1e-3)
    assert not caught.value.result.complete
    allowed = flat_bounces(most_events=1e6)
    assert len(times(allowed, "impact")) == pytest.approx(0.01 * G / 4e-5, abs=2)
    with pytest.raises(lf.ModelError, match="most_events"):
        lf.EventDriven(most_events=0.0)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_impulses_of_what_sticks_follow_a_changing_load(tolerance: float) -> None:
    """m u_x = integral of 4 sin 2t + impulse of friction: nothing moves while it sticks, and yet forces change."""
    stepper = lf.EventDriven(rtol=tolerance, atol=1e-2 * tolerance)
    result = lf.simulate(gallery.stick_slip_block(), 1.9, stepper, record=0.019)
    load = 2.0 * (1.0 - np.cos(2.0 * result.times))
    assert np.abs(result.u[:, 0] - load - result.impulse[:, 0, 1]).max() < 50.0 * tolerance


def test_both_sides_of_every_event_are_stored() -> None:
    """The force of friction jumps where a sliding block comes to rest, between two instants of equal time."""
    scene = lf.Scene(gravity=(0.0, -G))
    block = scene.add(lf.Box(width=0.2, height=0.2, mass=1.0), position=(0.0, 0.1), velocity=(1.0, 0.0))
    scene.contact(block.surface(), floor_of(scene), friction=0.5, name="floor")
    result = lf.simulate(scene, 0.5, lf.EventDriven(), record=0.1)
    rest = 1.0 / (0.5 * G)
    (jump,) = np.flatnonzero((np.diff(result.times) == 0.0) & (np.abs(np.diff(result.force[:, 0, 1])) > 0.1))
    assert result.times[jump] == pytest.approx(rest, abs=1e-8)
    assert np.abs(result.force[jump : jump + 2, 0, 1]) == pytest.approx([0.5 * G, 0.0], abs=1e-6)
    assert np.abs(result.u[jump : jump + 2, 0]).max() < 1e-6
    assert set(np.round(np.arange(6) * 0.1, 9)) <= set(np.round(result.times, 9))


def test_friction_never_drives_what_an_impact_leaves_nearly_at_rest() -> None:
    """A box slid at -7e-8 m/s after an impact, against the direction chosen: friction fed it for a millisecond."""
    generator = np.random.default_rng(18)
    scene = lf.Scene(gravity=(0.0, -G))
    for point, normal in (((0.0, 0.0), (0.0, 1.0)), ((-0.6, 0.0), (1.0, 0.0)), ((0.6, 0.0), (-1.0, 0.0))):
        scene.ground.half_plane(point, normal)
    draw = generator.uniform
    for k in range(8):
        if k % 2:
            body = lf.Box(width=draw(0.1, 0.3), height=draw(0.05, 0.15), mass=draw(0.1, 10.0))
        else:
            body = lf.Disc(radius=draw(0.04, 0.09), mass=draw(0.1, 10.0))
        place = (draw(-0.3, 0.3), 0.25 + 0.33 * k)
        angle, velocity, rate = draw(-3.0, 3.0), draw(-1.0, 1.0, 2), draw(-5.0, 5.0)
        scene.add(body, position=place, angle=angle, velocity=velocity, angular_velocity=rate)
    scene.contact_all(friction=0.5)
    result = lf.simulate(scene, 0.6, lf.EventDriven(impact=Poisson(sequential=True)), record=1e-3)
    assert np.diff(result.energies.dissipated).min() > -1e-6
