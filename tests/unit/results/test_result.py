"""Queries of a result, its energy audit and its words, against motions known in closed form."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from lcpflex.results.doubts import doubts
from lcpflex.results.energy_balance import Energies
from lcpflex.results.result import STICK, Result

TOUCH = math.sqrt(2.0 * 0.5 / 9.81)


def test_audit_of_a_bounce_in_closed_form_leaves_nothing_unexplained(bounce: Result) -> None:
    assert bounce.energies.largest_remainder < 1e-13
    assert bounce.energies.scale == pytest.approx(2.0 * 9.81 * 0.5, rel=1e-2)


def test_audit_signs() -> None:
    """Work adds; friction, impacts and damping take; what is left over is unexplained, with its sign."""
    zero, ramp = np.zeros(3), np.array([0.0, 1.0, 2.0])
    driven = Energies.audit(ramp, zero, zero, zero, zero, zero, ramp)
    assert np.array_equal(driven.remainder, zero)
    lossy = Energies.audit(6.0 - 3.0 * ramp, zero, zero, ramp, ramp, ramp, zero)
    assert np.array_equal(lossy.remainder, zero)
    assert np.array_equal(lossy.dissipated, 3.0 * ramp)
    gained = Energies.audit(ramp, zero, zero, zero, zero, zero, zero)
    assert np.array_equal(gained.remainder, ramp)
    assert gained.relative_remainder == 1.0


def test_relative_remainder_does_not_depend_on_the_zero_of_the_potential(bounce: Result) -> None:
    e = bounce.energies
    raised = Energies.audit(e.kinetic * 1.01, e.elastic, e.potential + 1e3, e.friction, e.impact, e.damping, e.work)
    lowered = Energies.audit(e.kinetic * 1.01, e.elastic, e.potential - 1e3, e.friction, e.impact, e.damping, e.work)
    assert raised.relative_remainder == pytest.approx(lowered.relative_remainder, rel=1e-9)
    assert raised.relative_remainder == pytest.approx(0.01, rel=0.05)


def test_shapes_are_checked(bounce: Result) -> None:
    with pytest.raises(ModelError, match=r"impulse: shape \(101, 2\); expected \(101, 1, 2\)"):
        replace(bounce, impulse=np.zeros((101, 2)))
    with pytest.raises(ModelError, match=r"energies\.work"):
        replace(bounce.energies, work=np.zeros(3))


def test_contact_history_of_a_bounce(bounce: Result) -> None:
    floor = bounce.contact("floor")
    assert floor.first_touch == pytest.approx(TOUCH, rel=1e-15)  # from the event, not from the stored instants
    assert floor.impulse[-1, 0] == pytest.approx(2.0 * 9.81 * TOUCH * 1.6)
    assert floor.shares == (1.0, 0.0, 0.0)
    without_events = replace(bounce, events=()).contact("floor")
    assert without_events.first_touch is not None
    assert TOUCH <= without_events.first_touch < TOUCH + 0.005
    untouched = replace(bounce, events=(), impulse=0.0 * bounce.impulse)
    assert untouched.contact("floor").first_touch is None


def test_unknown_contact_names_the_known_ones(bounce: Result) -> None:
    with pytest.raises(ModelError, match=r"no contact 'flor', expected one of 'floor'"):
        bounce.contact("flor")


def test_summary_of_a_sound_run(bounce: Result) -> None:
    text = bounce.summary()
    for words in ("MoreauJean, step 0.001 s", "500 steps", "first touch at 0.319275 s", "Unverified", "1 unknown;"):
        assert words in text
    assert doubts(bounce) == ()
    impulse = 2.0 * 9.81 * TOUCH * 1.6
    assert f"{impulse:.4g} N s normal" in text


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"complete": False, "message": "a callback raised", "duration": 2.0}, "a callback raised"),
        ({"residual": np.full(101, 1e-3)}, "residual of 1.0e-03"),
        ({"residual": np.full(101, np.nan)}, "residual of nan"),
        ({"q": np.full((101, 1), np.nan)}, "not finite"),
        ({"found_wrong": ("the ball went through the floor",)}, "the ball went through the floor"),
    ],
)
def test_summary_says_what_casts_doubt(bounce: Result, change: dict[str, object], words: str) -> None:
    text = replace(bounce, **change).summary()  # type: ignore[arg-type]
    assert "NOT to be trusted" in text
    assert words in text


def test_summary_reports_energy_out_of_nothing(bounce: Result) -> None:
    e = bounce.energies
    grown = Energies.audit(e.kinetic * 1.2, e.elastic, e.potential, e.friction, e.impact, e.damping, e.work)
    assert "was gained without explanation" in replace(bounce, energies=grown).summary()
    shrunk = Energies.audit(e.kinetic * 0.8, e.elastic, e.potential, e.friction, e.impact, e.damping, e.work)
    assert "was lost without explanation" in replace(bounce, energies=shrunk).summary()


def test_rounding_of_a_scene_at_rest_casts_no_doubt(bounce: Result) -> None:
    """Nothing moves, 50 J of potential energy: what is left over is measured against what the potential can resolve."""
    zero = np.zeros(101)
    noise = 1e-14 * np.sin(np.arange(101.0))
    still = Energies.audit(zero, zero, 50.0 + noise, zero, zero, zero, zero)
    assert still.scale == pytest.approx(5e-9, rel=1e-6)
    assert still.relative_remainder < 1e-5
    assert doubts(replace(bounce, energies=still)) == ()


def test_contact_that_is_closed_at_the_start_touches_from_the_start(bounce: Result) -> None:
    resting = replace(bounce, gap=np.zeros((101, 1)), events=())
    assert resting.contact("floor").first_touch == 0.0


def test_deep_penetration_and_drift_cast_doubt(swing: Result) -> None:
    assert doubts(swing) == ()
    assert "penetrates by 10 mm" in doubts(replace(swing, penetration=np.full(41, 0.01)))[0]
    assert "drifted by 10 mm" in doubts(replace(swing, joint_drift=np.full(41, 0.01)))[0]


def test_indentation_of_laws_casts_no_doubt(swing: Result) -> None:
    """What contacts by law are indented by is said by that name; beside others, only those must not penetrate."""
    deep = replace(swing, penetration=np.full(41, 0.01), gap=np.full((41, 4), -0.02))
    assert "lost in impacts " in deep.summary()
    some = replace(deep, compliant=("stop", "roof"))
    assert "penetrates by 10 mm" in doubts(some)[0]
    assert "largest indentation at the stored instants 20 mm; largest penetration 10 mm;" in some.summary()
    assert "lost in impacts, contacts " in some.summary()
    law = replace(deep, compliant=swing.contact_names)
    assert doubts(law) == ()
    assert "largest indentation 10 mm; largest joint drift" in law.summary()
    assert "penetration" not in law.summary()
    assert "lost in contacts " in law.summary()


def test_trajectory_of_a_rim_point_is_a_cycloid(swing: Result) -> None:
    """A disc that rolls: the point of contact at t = 0 follows r (theta - sin theta), r (cos theta - 1)."""
    theta = 4.0 * swing.times
    path = swing.point("disc", (0.0, -0.05))
    np.testing.assert_allclose(path[:, 0], 0.5 + 0.05 * (theta - np.sin(theta)), atol=1e-14)
    np.testing.assert_allclose(path[:, 1], -0.85 - 0.05 * np.cos(theta), atol=1e-14)
    np.testing.assert_allclose(swing.velocity("disc", (0.0, -0.05))[0], 0.0, atol=1e-14)


def test_velocity_is_the_rate_of_the_trajectory(swing: Result) -> None:
    """On a body that turns and bends, against central differences of a finer motion."""
    step = 1e-6
    ahead = replace(swing, q=swing.q + step * swing.u)
    behind = replace(swing, q=swing.q - step * swing.u)
    for point in ("right", (0.35, 0.01)):
        rate = (ahead.point("pendulum", point) - behind.point("pendulum", point)) / (2.0 * step)
        np.testing.assert_allclose(swing.velocity("pendulum", point), rate, atol=1e-8)


def test_point_on_an_outline_lies_between_its_neighbours(swing: Result) -> None:
    middle = swing.point("pendulum", (0.35, 0.01))
    beside = [swing.point("pendulum", (0.35 + side * 0.004, 0.01)) for side in (-1.0, 1.0)]
    np.testing.assert_allclose(middle, 0.5 * (beside[0] + beside[1]), atol=1e-4)


@pytest.mark.parametrize(
    ("body", "point", "words"),
    [
        ("pendul", "right", "no body 'pendul', expected one of 'pendulum', 'disc'"),
        ("pendulum", "rigth", "has no point 'rigth'"),
        ("pendulum", (0.35, 0.5), "neither a named point nor on the outline"),
        ("disc", (math.nan, 0.0), "two finite numbers"),
    ],
)
def test_unknown_points(swing: Result, body: str, point: str | tuple[float, float], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        swing.point(body, point)


def test_points_of_a_users_own_system(bounce: Result) -> None:
    with pytest.raises(ModelError, match="no material points"):
        bounce.point("ball", "center")


def test_dataframe(swing: Result, bounce: Result) -> None:
    frame = swing.to_dataframe()
    assert list(frame.columns[:6]) == [f"pendulum.{c}" for c in ("x", "y", "angle", "mode 1", "mode 2", "mode 3")]
    np.testing.assert_array_equal(frame["disc.angle'"], -4.0)
    np.testing.assert_array_equal(frame["disc on floor.tangential force"], -2.0)
    np.testing.assert_array_equal(frame.index, swing.times)
    assert "q 1" in bounce.to_dataframe().columns


def test_shares_sum_to_one(swing: Result) -> None:
    state = swing.state.copy()
    k = swing.contact_names.index("disc on floor")
    state[:10, k] = STICK
    shares = replace(swing, state=state).contact("disc on floor").shares
    assert shares == pytest.approx((0.0, 10 / 41, 31 / 41))


def test_a_contact_is_told_in_a_line() -> None:
    scene = lf.Scene()
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, 0.11))
    scene.contact(ball.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="floor")
    result = lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3))
    assert repr(result.contact("floor")) == "<contact 'floor': 11 stored instants, never touched>"
    result = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3))
    assert "floor': 101 stored instants, first touch at 0.04" in repr(result.contact("floor"))
