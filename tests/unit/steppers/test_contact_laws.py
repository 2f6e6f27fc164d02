"""Smooth steps under laws with memory: impact speed, mass, largest indentation and bristles of each contact."""

from __future__ import annotations

import math
from itertools import zip_longest
from typing import Any

import numpy as np
import pytest
from scipy.integrate import BDF

import lcpflex as lf
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.damping.dissipative import (
    Jankowski,
    KelvinVoigt,
    KuwabaraKono,
    PermanentIndentation,
    Ristow,
    Tsuji,
)
from lcpflex.force_laws.damping.hysteresis import HysteresisDamping, HysteresisFactor
from lcpflex.force_laws.damping.restitution import restitution_of
from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
from lcpflex.force_laws.elastic.hertz import Hertz
from lcpflex.force_laws.elastic.kernels import indentation_of, stored_energy
from lcpflex.force_laws.elastic.line_contact import Johnson
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.force_laws.friction.bristles import Bristle, LuGre
from lcpflex.force_laws.friction.laws import (
    Ambrosio,
    ArctangentCoulomb,
    BengisuAkay,
    BrownMcPhee,
    RampCoulomb,
    SmoothedCoulomb,
    Threlfall,
)
from lcpflex.force_laws.layout import END
from tests.scenes import floor_of

RADIUS = 0.1
FINE = lf.ExplicitRungeKutta(rtol=1e-10, atol=1e-12)
STEEL = Material(207e9, 0.3)
HALF = ContactLaw(PowerLaw(1e6), HysteresisDamping(0.5))


def falling(*balls: tuple[float, float], gravity: float = 0.0, slip: float = 0.0, friction: float = 0.0) -> lf.Scene:
    """Balls of 1 kg in a row over one floor: the gap [m] and speed [m/s] of each."""
    scene = lf.Scene(gravity=(0.0, -gravity))
    floor = floor_of(scene)
    for k, (gap, speed) in enumerate(balls):
        disc = lf.Disc(radius=RADIUS, mass=1.0)
        body = scene.add(disc, name=f"ball {k}", position=(k, RADIUS + gap), velocity=(slip, -speed))
        scene.contact(body.surface(), floor, name=f"floor {k}", friction=friction)
    return scene


@pytest.mark.parametrize(
    ("integrator", "error"),
    [
        (lf.ExplicitRungeKutta(), 2e-7),
        (FINE, 2e-9),
        (lf.Verlet(2e-5), 2e-7),
        (lf.Stiff(rtol=1e-8, atol=1e-10), 2e-7),
        (lf.Stiff(rtol=1e-8, atol=1e-10, method=BDF), 2e-6),
    ],
    ids=["rk", "fine", "verlet", "radau", "bdf"],
)
def test_exact_factor_returns_its_restitution(integrator: Any, error: float) -> None:
    """Three impacts: two that begin at one instant, one that begins the run, each with its own speed."""
    scene = falling((0.01, 1.0), (0.01, 1.0), (0.0, 3.0))
    result = lf.simulate(scene, 0.04, lf.Smooth(HALF, integrator=integrator), record=1e-3)
    np.testing.assert_allclose(result.u[-1, 1::3], [0.5, 0.5, 1.5], rtol=error)
    assert not result.warnings


def test_stored_instants_do_not_matter() -> None:
    ends = [
        lf.simulate(falling((0.01, 1.0), gravity=9.81), 0.1, lf.Smooth(HALF), record=record)
        for record in (0.1, 1e-3, 1.23e-4)
    ]
    for end in ends[1:]:
        assert end.steps == ends[0].steps
        np.testing.assert_array_equal(end.q[-1], ends[0].q[-1])
        np.testing.assert_array_equal(end.u[-1], ends[0].u[-1])


@pytest.mark.parametrize("integrator", [FINE, lf.Stiff(rtol=1e-9, atol=1e-11)], ids=["explicit", "stiff"])
def test_two_balls_collide(integrator: Any) -> None:
    """Masses 1 and 3: the effective mass is that of both, momentum stays, they part with e times the speed."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    a = scene.add(lf.Disc(radius=0.1, mass=1.0), name="a", velocity=(2.0, 0.0))
    b = scene.add(lf.Disc(radius=0.2, mass=3.0), name="b", position=(0.31, 0.0), velocity=(-1.0, 0.0))
    scene.contact(a.surface(), b.surface(), name="pair")
    for damping, e in ((HysteresisDamping(0.6), 0.6), (Tsuji(0.6), restitution_of(Tsuji, 0.6))):
        law = ContactLaw(PowerLaw(1e6), damping)
        result = lf.simulate(scene, 0.05, lf.Smooth(law, integrator=integrator), record=1e-3)
        va, vb = result.u[-1, 0], result.u[-1, 3]
        assert vb - va == pytest.approx(3.0 * e, rel=1e-7)
        assert va + 3.0 * vb == pytest.approx(-1.0, abs=1e-10)


@pytest.mark.parametrize(
    "integrator", [FINE, lf.Verlet(1e-6), lf.Stiff(rtol=1e-8, atol=1e-10)], ids=["rk", "verlet", "stiff"]
)
def test_effective_mass_with_a_joint(integrator: Any) -> None:
    """A rod of 1 kg and 1 m swings down onto a stop: 1/3 kg at its tip, 1/4 kg if it were free there."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    rod = lf.RigidBody(mass=1.0, inertia=1.0 / 12.0, center=(0.5, 0.0), points={"end": (0.0, 0.0)})
    body = scene.add(rod, name="rod", angular_velocity=-1.0)
    scene.join(lf.Revolute(body.point("end"), scene.ground.at(0.0, 0.0)))
    scene.contact(body.node(1.0, 0.0), floor_of(scene), name="stop")
    law = ContactLaw(PowerLaw(1e7, 1.0), KelvinVoigt(0.5))
    result = lf.simulate(scene, 2e-3, lf.Smooth(law, integrator=integrator), record=1e-5)
    expected = restitution_of(KelvinVoigt, 0.5)
    assert expected == pytest.approx(0.5503, abs=5e-5)
    assert result.u[-1, 2] == pytest.approx(expected, rel=2e-3 if isinstance(integrator, lf.Verlet) else 1e-6)


def test_each_bounce_has_its_own_speed() -> None:
    """Heights fall by e^2 from bounce to bounce."""
    law = ContactLaw(PowerLaw(1e11), HysteresisDamping(0.7))
    result = lf.simulate(falling((0.5, 0.0), gravity=9.81), 1.6, lf.Smooth(law), record=2e-5)
    height = result.q[:, 1] - RADIUS
    peaks = np.flatnonzero((height[1:-1] > height[:-2]) & (height[1:-1] >= height[2:]) & (height[1:-1] > 1e-3)) + 1
    assert len(peaks) >= 4
    # gravity works along the indentation, too: by 2e-4 of the height of the first bounce, 2e-3 of that of the fourth
    np.testing.assert_allclose(height[peaks[:4]], 0.5 * 0.49 ** np.arange(1, 5), rtol=4e-3)
    assert result.energies.relative_remainder < 1e-6


@pytest.mark.parametrize("integrator", [lf.ExplicitRungeKutta(), lf.Stiff()], ids=["rk", "stiff"])
def test_comes_to_rest(integrator: Any) -> None:
    """After bounces without number a ball rests where its weight is carried, and steps grow long again."""
    damping = HysteresisDamping(0.5, guard_speed=1e-2)
    stepper = lf.Smooth(ContactLaw(PowerLaw(1e6), damping), integrator=integrator)
    result = lf.simulate(falling((0.02, 0.0), gravity=9.81), 1.0, stepper, record=1e-3)
    assert np.abs(result.u[-1]).max() < 1e-6
    assert RADIUS - result.q[-1, 1] == pytest.approx((9.81 / 1e6) ** (2.0 / 3.0), rel=1e-4)
    stored = result.energies.stored
    assert np.diff(stored).max() < 1e-6 * result.energies.scale
    assert result.energies.relative_remainder < 1e-4
    assert result.steps < 20000


DAMPINGS: list[Any] = [
    None,
    *(HysteresisDamping(0.6, factor) for factor in HysteresisFactor),
    KelvinVoigt(0.6),
    Tsuji(0.6),
    KuwabaraKono(1e-3),
    Ristow(50.0),
    Jankowski(0.6),
    PermanentIndentation(0.6),
]
LINEAR = (HysteresisFactor.YE, HysteresisFactor.PANT)
# The force ends before the indentation does, and what is in the spring is lost. This flight has steps of any length,
# which leave that much of the integral of the loss.
ENDING_EARLY = (KelvinVoigt, Tsuji, KuwabaraKono, Ristow, Jankowski)
FRICTIONS: list[Any] = [
    SmoothedCoulomb(1e-2),
    ArctangentCoulomb(1e-2),
    RampCoulomb(1e-2),
    Threlfall(1e-2),
    Ambrosio(1e-3, 1e-2),
    BengisuAkay(1e-2),
    BrownMcPhee(1e-2),
    LuGre(),
    Bristle(),
]


@pytest.mark.parametrize(
    ("damping", "friction"),
    list(zip_longest(DAMPINGS, (FRICTIONS * 3)[: len(DAMPINGS)])),
    ids=[f"{getattr(getattr(d, 'factor', None), 'name', type(d).__name__)}" for d in DAMPINGS],
)
def test_energy_is_accounted_for(damping: Any, friction: Any) -> None:
    """An oblique bounce under each damping, with each friction: nothing is gained, and the account closes."""
    linear = isinstance(damping, KelvinVoigt) or getattr(damping, "factor", None) in LINEAR
    law = ContactLaw(PowerLaw(1e5, 1.0) if linear else PowerLaw(1e6), damping, friction)
    integrator = lf.ExplicitRungeKutta(rtol=1e-9, atol=1e-12)
    scene = falling((0.005, 1.0), slip=0.5, friction=0.3)
    result = lf.simulate(scene, 0.04, lf.Smooth(law, integrator=integrator), record=1e-4)
    energies = result.energies
    assert result.u[-1, 1] > 0.0
    assert energies.friction[-1] > 1e-3 * energies.scale
    assert energies.relative_remainder < (5e-5 if isinstance(damping, ENDING_EARLY) else 1e-6)
    assert energies.stored.max() <= energies.stored[0] * (1.0 + 1e-8)
    for lost in (energies.friction, energies.impact):
        assert lost.min() >= -1e-9 * energies.scale
    assert np.diff(energies.impact).min() >= -1e-9 * energies.scale


def test_permanent_indentation_and_its_return() -> None:
    """A ball pressed in, let go and pressed in deeper: e is exact, and there is one unloading for each loading."""
    law = ContactLaw(PowerLaw(1e6), PermanentIndentation(0.6))
    for integrator in (FINE, lf.Stiff(rtol=1e-9, atol=1e-11)):
        bounce = lf.simulate(falling((0.01, 1.0)), 0.05, lf.Smooth(law, integrator=integrator), record=1e-3)
        assert bounce.u[-1, 1] == pytest.approx(0.6, rel=1e-6)
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = scene.add(lf.Disc(radius=RADIUS, mass=1.0), position=(0.0, RADIUS))
    scene.contact(body.surface(), floor_of(scene), name="floor")
    scene.load(lf.Force(body.point("center"), (0.0, lambda t: -200.0 * t * math.sin(40.0 * t) ** 2)))
    result = lf.simulate(scene, 0.16, lf.Smooth(law), record=1e-3)
    assert result.penetration.max() > 1e-4
    assert np.diff(result.energies.impact).min() > -1e-9 * result.energies.scale
    assert result.energies.relative_remainder < 1e-6


def test_hollow_corner_holds_two_memories() -> None:
    """A ball falls askew into a right-angled groove: each side has its own impact, no step is without length."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    groove = scene.ground.chain([(1.0, 1.0), (0.0, 0.0), (-1.0, 1.0)])
    body = scene.add(lf.Disc(radius=RADIUS, mass=1.0), position=(0.02, 0.2))
    scene.contact(body.surface(), groove, friction=0.3, name="groove")
    law = ContactLaw(PowerLaw(1e6), HysteresisDamping(0.5, guard_speed=1e-2), LuGre())
    result = lf.simulate(scene, 1.0, lf.Smooth(law), record=1e-3)
    assert np.abs(result.u[-1]).max() < 1e-3
    assert result.q[-1, 0] == pytest.approx(0.0, abs=1e-4)
    assert result.energies.relative_remainder < 1e-4


def test_bristles_go_along_a_polyline() -> None:
    """A node drawn over the joints of a straight chain keeps its bristle: as on one piece."""

    def drawn(places: list[tuple[float, float]]) -> lf.Result:
        scene = lf.Scene(gravity=(0.0, -9.81))
        slab = lf.RigidBody(mass=1.0, inertia=0.1)
        body = scene.add(slab, name="slab", position=(-0.05, 0.0))
        scene.load(lf.Force(body.at(0.0, 0.0), (4.0, 0.0)))
        scene.contact(body.node(0.0, 0.0), scene.ground.chain(places), friction=0.3, name="way")
        law = ContactLaw(PowerLaw(1e5, 1.0), HysteresisDamping(0.5, guard_speed=0.01), LuGre())
        return lf.simulate(scene, 0.3, lf.Smooth(law, integrator=FINE), record=1e-3)

    pieces = drawn([(x, 0.0) for x in (0.2, 0.02, -0.01, -0.04, -0.2)])
    whole = drawn([(0.2, 0.0), (-0.2, 0.0)])
    assert pieces.q[-1, 0] > -0.01
    np.testing.assert_allclose(pieces.q[-1], whole.q[-1], atol=1e-9)
    np.testing.assert_allclose(pieces.force[:, 0], whole.force[:, 0], atol=1e-5)


def test_fixed_steps_carry_bristles() -> None:
    """Friction states relax faster than a step of Verlet's method takes: it does not blow up; too stiff ones warn."""
    scene = falling((0.0, 0.0), gravity=9.81, slip=1.0, friction=0.3)
    damping = HysteresisDamping(0.5, guard_speed=0.1)
    fine = lf.simulate(scene, 0.05, lf.Smooth(ContactLaw(PowerLaw(1e6), damping, LuGre()), integrator=FINE))
    law = ContactLaw(PowerLaw(1e6), damping, LuGre())
    fixed = lf.simulate(scene, 0.05, lf.Smooth(law, integrator=lf.Verlet(1e-4)))
    np.testing.assert_allclose(fixed.u[-1], fine.u[-1], atol=2e-3)
    assert not fixed.warnings
    stiff = ContactLaw(PowerLaw(1e6), damping, LuGre(stiffness=1e8))
    assert "unstable" in " ".join(lf.simulate(scene, 0.05, lf.Smooth(stiff, integrator=lf.Verlet(1e-4))).warnings)


def test_stiff_steps_enter_contacts_with_a_jump() -> None:
    """Discs tumble into a trough: damping has no slope at the touch, and bristles begin to move there at once."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    trough = scene.ground.chain([(1.0, 2.0), (0.25, 0.0), (-0.25, 0.0), (-1.0, 2.0)])
    disc = lf.Disc(radius=RADIUS, mass=1.0)
    bodies = [
        scene.add(disc, name=f"disc {k}", position=(x, 0.2 + 0.25 * k)) for k, x in enumerate((-0.107, 0.135, -0.119))
    ]
    for k, body in enumerate(bodies):
        scene.contact(body.surface(), trough, friction=0.3)
        for other in bodies[:k]:
            scene.contact(body.surface(), other.surface(), friction=0.3)
    stepper = lf.Smooth(ContactLaw(PowerLaw(1e6), Tsuji(0.5), Bristle()), integrator=lf.Stiff())
    result = lf.simulate(scene, 0.5, stepper, record=1e-3)
    assert result.steps < 2000
    assert result.energies.friction[-1] > 0.0
    assert result.energies.relative_remainder < 1e-3


def test_laws_of_pairs() -> None:
    """Two balls, two laws, each with its own restitution and stiffness."""
    scene = falling((0.0, 1.0), (0.0, 1.0))
    laws = {"floor 0": HALF, "floor 1": ContactLaw(PowerLaw(4e6, 1.0), HysteresisDamping(0.9))}
    result = lf.simulate(scene, 0.03, lf.Smooth(laws=laws, integrator=FINE), record=1e-3)
    np.testing.assert_allclose(result.u[-1, 1::3], [0.5, 0.9], rtol=1e-8)
    with pytest.raises(lf.ModelError, match=r"contact 'floor 1' has no force law.*EventDriven/MoreauJean"):
        lf.simulate(scene, 0.03, lf.Smooth(laws={"floor 0": HALF}))


def test_law_of_the_scene() -> None:
    """It goes before that of the stepper, and after one by name."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = scene.add(lf.Disc(radius=RADIUS, mass=1.0), position=(0.0, RADIUS), velocity=(0.0, -1.0))
    scene.contact(body.surface(), floor_of(scene), name="floor", law=HALF)
    other = ContactLaw(PowerLaw(1e6), HysteresisDamping(0.8))
    for stepper, e in ((lf.Smooth(), 0.5), (lf.Smooth(other), 0.5), (lf.Smooth(laws={"floor": other}), 0.8)):
        assert lf.simulate(scene, 0.03, stepper).u[-1, 1] == pytest.approx(e, rel=1e-6)


@pytest.mark.parametrize("integrator", [FINE, lf.Verlet(1e-6), lf.Stiff()], ids=["rk", "verlet", "stiff"])
def test_contact_that_begins_indented_shows_its_impact_speed_at_once(integrator: Any) -> None:
    """A node comes over the end of a chain, 5 mm below it: the end of the step there is the first instant of contact.

    A proportional damping chi = a / v_0 is told from the force: v_0^2 = rate^2 + 2 E / m, not the rate alone.
    """
    depth, rate, stiffness = 5e-3, 1.0, 1e6
    law = ContactLaw(PowerLaw(stiffness), HysteresisDamping(0.5, HysteresisFactor.HUNT_CROSSLEY))
    scene = lf.Scene(gravity=(0.0, 0.0))
    slab = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), position=(0.50002, -depth), velocity=(-2.0, -rate))
    scene.contact(slab.node(0.0, 0.0), scene.ground.chain([(0.5, 0.0), (-0.5, 0.0)]), name="edge")
    result = lf.simulate(scene, 2e-5, lf.Smooth(law, integrator=integrator), record=0.0)
    first = int(np.flatnonzero(result.force[:, 0, 0])[0])
    impact = math.sqrt(rate**2 + 2.0 * 0.4 * stiffness * depth**2.5)
    expected = stiffness * depth**1.5 * (1.0 + 1.5 * 0.5 * rate / impact)
    assert impact == pytest.approx(1.554, abs=1e-3)
    np.testing.assert_allclose(result.force[first, 0, 0], expected, rtol=2e-2)


def test_law_of_a_scene_in_words() -> None:
    scene = falling((0.0, 1.0))
    result = lf.simulate(scene, 0.02, lf.Smooth(HALF), record=1e-3)
    text = result.summary()
    assert result.penetration.max() > 2e-3
    assert f"largest indentation {1e3 * result.penetration.max():.4g} mm; largest joint drift" in text
    assert "lost in contacts" in text
    assert "Unverified: how accurate" in text


def test_range_of_validity() -> None:
    """Beyond it a run ends, or, by choice, says so: once, whatever the number of chunks."""
    pair = CylinderPair.internal(0.0101, 0.01, 0.02, STEEL)
    speed = 1.5
    for integrator in (lf.ExplicitRungeKutta(), lf.Verlet(1e-7), lf.Stiff()):
        strict = lf.Smooth(ContactLaw(Johnson(pair)), integrator=integrator)
        with pytest.raises(lf.StepError, match=r"indentation of contact 'floor 0' is .* valid up to") as caught:
            lf.simulate(falling((1e-4, speed)), 2e-4, strict, record=1e-6)
        assert 0.0 < caught.value.result.times[-1] < 1e-4
        lenient = lf.Smooth(ContactLaw(Johnson(pair, lenient=True)), integrator=integrator)
        result = lf.simulate(falling((1e-4, speed)), 2e-4, lenient, record=1e-6)
        assert [w for w in result.warnings if "beyond the" in w] == list(result.warnings)
        assert len(result.warnings) == 1
        assert "contact 'floor 0' has reached" in result.warnings[0]


@pytest.mark.parametrize("law", [Johnson(CylinderPair.external(0.1, 0.1, 0.1, STEEL)), Hertz.spheres(0.1, 0.1, STEEL)])
def test_indentation_of_an_energy_is_found(law: Any) -> None:
    """The limit of a step asks for it, at impacts of any energy."""
    row = ContactLaw(law).row()
    kinds, p = np.array(row.kinds), np.array(row.parameters)
    for energy in np.geomspace(1e-25, min(1e12, stored_energy(kinds, p, p[END])), 60):
        depth = indentation_of(kinds, p, energy)
        assert 0.0 < depth < math.inf
        assert stored_energy(kinds, p, depth) == pytest.approx(energy, rel=0.02)


@pytest.mark.parametrize(
    "integrator", [lf.ExplicitRungeKutta(), lf.Verlet(1e-4), lf.Stiff()], ids=["rk", "verlet", "stiff"]
)
def test_systems_of_users_remember(integrator: Any) -> None:
    """Two masses of a user on a floor each, the driver in Python: as the scene, step by step."""
    law = ContactLaw(PowerLaw(1e5), HysteresisDamping(0.5), LuGre())
    stepper = lf.Smooth(law, integrator=integrator)
    system = lf.UserSystem(
        q=[0.005, 0.012],
        u=[-1.0, -2.0],
        mass=np.diag([1.0, 1.0]),
        force=lambda t, q, u: [0.0, 0.0],
        gaps=lambda q: q,
        normals=np.eye(2),
        names=["a", "b"],
    )
    own = lf.simulate(system, 0.05, stepper, record=5e-3)
    scene = lf.simulate(falling((0.005, 1.0), (0.012, 2.0)), 0.05, stepper, record=5e-3)
    np.testing.assert_allclose(own.u[-1], [0.5, 1.0], rtol=1e-4)
    np.testing.assert_allclose(own.u, scene.u[:, 1::3], rtol=1e-4, atol=1e-6)
