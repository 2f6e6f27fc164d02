"""The actual axial force of a beam in its bending: columns, their energy, spin, and the rods of slider-cranks."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.reduction.stiffening import Stiffening
from lcpflex.studies.vibrations import small_vibrations
from tests.analytic.test_rotating_beams import kanes_beam, spun_up
from tests.rates import assert_rate, growth

LENGTH, WIDTH, THICKNESS, DENSITY, MODULUS = 1.0, 0.02, 0.005, 2700.0, 7e10
AREA = WIDTH * THICKNESS
RIGIDITY = MODULUS * AREA * THICKNESS**2 / 12.0
EULER = math.pi**2 * RIGIDITY / LENGTH**2
FIRST = (math.pi / LENGTH) ** 2 * math.sqrt(RIGIDITY / (DENSITY * AREA))  # of the pinned beam [rad/s]
PERIOD = 2.0 * math.pi / FIRST
ACTUAL = Stiffening(axial_force="actual")
COLUMN = lf.Beam(LENGTH, WIDTH, THICKNESS, DENSITY, MODULUS, elements=20)


def column(share: float, modes: int | None = 8, bow: float = 0.0, weight: float = 0.0) -> lf.Scene:
    """A pinned column under ``share`` of Euler's load; at the start it is as long as it is under that load.

    ``bow``: deflection of its middle at the start [m], a half sine; ``weight`` [N/m].
    """
    k = math.pi / LENGTH

    def start(x: float, y: float) -> tuple[float, float]:
        shortened = 0.25 * (bow * k) ** 2 * (x + math.sin(2.0 * k * x) / (2.0 * k))
        return -shortened - share * EULER * x / (MODULUS * AREA), bow * math.sin(k * x)

    body = COLUMN.reduce(modes, stiffening=ACTUAL, interfaces=("left", "right"))
    dx, dy, angle, modal = body.project(start)
    scene = lf.Scene(gravity=(0, -weight / (DENSITY * AREA)))
    beam = scene.add(body, "beam", position=(dx, dy), angle=angle, modal=modal)
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0, 0)))
    scene.join(lf.PointOnLine(beam.point("right"), scene.ground.at(LENGTH, 0), (1, 0)))
    scene.load(lf.Force(beam.point("right"), (-share * EULER, 0.0)))
    return scene


def middle(
    scene: lf.Scene, periods: float, stepper: object, record: float | None = None
) -> tuple[lf.Result, np.ndarray]:
    result = lf.simulate(scene, periods * PERIOD, stepper, record=record, project=True)  # type: ignore[arg-type]
    return result, result.point("beam", "center")[:, 1]


@pytest.mark.parametrize("modes", [None, 8])
@pytest.mark.parametrize(("share", "tolerance"), [(-0.5, 0.01), (0.0, 0.01), (0.5, 0.01), (0.9, 0.02)])
def test_frequency_of_a_loaded_column(share, tolerance, modes):
    """omega = omega_1 sqrt(1 - P / P_Euler)."""
    found = small_vibrations(column(share, modes))
    assert found.frequencies[0] == pytest.approx(FIRST * math.sqrt(1.0 - share), rel=tolerance)
    assert found.growth < 1e-6 * FIRST


@pytest.mark.parametrize("share", [-0.5, 0.5, 0.9])
def test_sag_of_a_loaded_column(share):
    """Under its weight: 5 q L^4 / (384 E I) times 12 (2 sec u - 2 - u^2) / (5 u^4), u^2 = pi^2 P / (4 P_E)."""
    weight = 0.1
    scene = column(share, weight=weight)
    q, body = small_vibrations(scene).q, scene.parts().placed[0].source
    assert body is not None
    center = body.points["center"]
    local = center.place + q[3:] @ center.phi
    sag = -(q[1] + math.sin(q[2]) * local[0] + math.cos(q[2]) * local[1])
    u2 = math.pi**2 * share / 4.0
    secant = 1.0 / math.cos(math.sqrt(u2)) if u2 > 0.0 else 1.0 / math.cosh(math.sqrt(-u2))
    grown = 12.0 * (2.0 * secant - 2.0 - u2) / (5.0 * u2**2)
    assert sag == pytest.approx(5.0 * weight * LENGTH**4 / (384.0 * RIGIDITY) * grown, rel=1e-4)


@pytest.mark.parametrize("share", [1.2, 2.0])
def test_column_beyond_eulers_load_grows_as_it_should(share):
    """exp(sqrt(P / P_Euler - 1) omega_1 t), linearised and stepped."""
    rate = FIRST * math.sqrt(share - 1.0)
    assert small_vibrations(column(share)).growth == pytest.approx(rate, rel=0.02)
    times = 5.0 / rate
    result, sag = middle(column(share, bow=1e-6), times / PERIOD, lf.GeneralizedAlpha(PERIOD / 400))
    late = (result.times > 0.5 * times) & (result.times < times)
    assert growth(result.times[late], sag[late]) == pytest.approx(rate, rel=0.02)
    assert result.found_wrong == ()  # slopes are still small


def test_trust_ends_with_the_small_slopes():
    """Just below, it stays: the same column is stopped before its slopes pass 0.1."""
    scene, stepper = column(2.0, bow=1e-3), lf.GeneralizedAlpha(PERIOD / 400)
    rate = FIRST
    until = math.acosh(0.1 / (1e-3 * math.pi / LENGTH)) / rate  # slope of the half sine at the ends
    before, _ = middle(scene, 0.97 * until / PERIOD, stepper)
    assert before.found_wrong == ()
    after, _ = middle(scene, 1.03 * until / PERIOD, stepper)
    assert len(after.found_wrong) == 1
    assert re.search(r"slopes of the beam 'beam' pass 0\.1 at t = ", after.found_wrong[0])
    assert "NOT to be trusted" in after.summary()


def test_energy_closes_over_twenty_periods():
    """With rho = 1 the scheme takes no energy: the audit is that of the coupled term."""
    result, sag = middle(column(0.5, bow=1e-3), 20.0, lf.GeneralizedAlpha(PERIOD / 400, rho_inf=1.0))
    assert result.energies.relative_remainder < 1e-6
    assert np.abs(sag).max() > 0.9e-3
    shortening = np.ptp(result.point("beam", "right")[:, 0])
    assert shortening > 0.2 * (math.pi * 1e-3) ** 2 / 4.0  # the term is at work: it draws the end in


@pytest.mark.parametrize(("stepper", "order"), [(lf.GeneralizedAlpha, 2.0), (lf.MoreauJean, 2.0)])
def test_order_of_steps_is_kept(stepper, order):
    """Moreau-Jean's, too, is of order 2 without contacts, at theta = 1/2."""
    scene = column(0.5, bow=5e-3)
    steps = PERIOD / np.array([100.0, 200.0, 400.0, 800.0])
    ends = [middle(scene, 2.0, stepper(step=float(h)), record=PERIOD)[1][-1] for h in steps]
    changes = np.abs(np.diff(ends))
    assert_rate(steps[:-1], changes, order, within=0.2)


@pytest.mark.parametrize("stepper", [lf.EventDriven(), lf.Smooth(), lf.MasslessBoundary(), lf.MoreauJean(PERIOD / 800)])
def test_every_stepper_knows_the_axial_force(stepper):
    """Half a period of the column at half of Euler's load: cos(omega t) goes to -1."""
    share, half = 0.5, 0.5 / math.sqrt(0.5)
    result, sag = middle(column(share, modes=2, bow=1e-3), half, stepper)
    assert result.complete
    assert sag[-1] == pytest.approx(-sag[0], rel=0.01)


@pytest.mark.parametrize(
    "stiffening",
    [Stiffening(held="left"), ACTUAL, Stiffening(held="left", axial_force="actual")],
    ids=["by spin", "actual", "both"],
)
@pytest.mark.parametrize("modes", [pytest.param(None, marks=pytest.mark.slow), 8])
def test_spin_up_by_either_way_or_both(stiffening, modes):
    """Kane's beam, in which centrifugal tension is all there is; spin must not count twice."""
    interfaces = ("left",) if modes else ()
    result, lag, _ = spun_up(kanes_beam().reduce(modes, stiffening=stiffening, interfaces=interfaces))
    assert result.complete
    assert lag.min() == pytest.approx(-0.5744, rel=0.01)


ROD, CRANK, SPEED = 0.4, 0.1, 40.0  # [m], [m], [rad/s]
ROD_EULER = math.pi**2 * MODULUS * WIDTH * 0.004**3 / 12.0 / ROD**2
TURN = 2.0 * math.pi / SPEED


def slider_crank(push: float, pieces: int, stiffening: Stiffening | None) -> lf.Scene:
    """A rod of one beam or of linear ones welded, pressed by ``push`` sin^2 [N] on its slider."""
    scene = lf.Scene(gravity=(0, 0))
    crank = scene.add(lf.RigidBody(1.0, 1.0), "crank", angular_velocity=SPEED)
    scene.join(lf.Revolute(crank.at(0, 0), scene.ground.at(0, 0)))
    scene.join(lf.DrivenAngle(crank.at(0, 0), scene.ground.at(0, 0), lf.Table([0, TURN], [0, TURN * SPEED])))
    piece, joint, joined = ROD / pieces, lf.Revolute, crank.at(CRANK, 0)
    beam = lf.Beam(piece, WIDTH, 0.004, DENSITY, MODULUS, elements=20 if pieces == 1 else 3)
    for k in range(pieces):
        body = beam.reduce(8, stiffening=stiffening, interfaces=("left", "right")) if pieces == 1 else beam.reduce(None)
        velocity = (0.0, CRANK * SPEED * (1.0 - k / pieces))
        turning = -CRANK * SPEED / ROD
        rod = scene.add(body, f"rod {k}", position=(CRANK + k * piece, 0), velocity=velocity, angular_velocity=turning)
        scene.join(joint(rod.point("left"), joined))
        joint, joined = lf.Weld, rod.point("right")
    slider = scene.add(lf.RigidBody(0.02, 1e-4), "slider", position=(CRANK + ROD, 0))
    scene.join(lf.Revolute(joined, slider.at(0, 0)))
    scene.join(lf.Prismatic(slider.at(0, 0), scene.ground.at(CRANK + ROD, 0), axis=(1, 0)))
    times = np.linspace(0.0, TURN, 101)
    scene.load(lf.Force(slider.at(0, 0), (lf.Table(times, -push * np.sin(math.pi * times / TURN) ** 2), 0)))
    return scene


def turned(push: float, pieces: int, stiffening: Stiffening | None = None) -> tuple[lf.Result, np.ndarray]:
    """One turn, and the deflection of the middle of the rod from the line of its ends [m]."""
    result = lf.simulate(
        slider_crank(push, pieces, stiffening), TURN, lf.GeneralizedAlpha(TURN / 2000), record=TURN / 200
    )
    left, right = result.point("rod 0", "left"), result.point(f"rod {pieces - 1}", "right")
    place = result.point("rod 0", "center") if pieces == 1 else result.point(f"rod {pieces // 2}", "left")
    along, off = right - left, place - left
    return result, (along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]) / np.hypot(*along.T)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_rod_of_a_slider_crank_bends_like_eight_welded_pieces(share):
    """Its compression peaks at so much of Euler's load, as the linear rod says, which is off by 20 to 45 %."""
    push = share * ROD_EULER - 19.0  # the rest is inertia
    _, pieces = turned(push, 8)
    linear, wrong = turned(push, 1)
    told = re.search(r"compression of .* ([\d.]+) % of its Euler load", " ".join(linear.warnings))
    assert told
    assert float(told[1]) == pytest.approx(100.0 * share, rel=0.1)
    result, one = turned(push, 1, ACTUAL)
    size = np.abs(pieces).max()
    assert np.abs(one - pieces).max() < 0.02 * size
    assert np.abs(wrong - pieces).max() > 0.1 * size
    assert result.warnings == ()
    assert result.found_wrong == ()
