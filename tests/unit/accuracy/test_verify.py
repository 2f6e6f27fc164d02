"""The error of a run, measured: against a closed form, by its reruns, from files, and where it is refused."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.accuracy.comparison import bodies_of, differences
from lcpflex.results.measured_error import PARTED

HEIGHT, RADIUS, GRAVITY, BOUNCE = 0.25, 0.05, 9.81, 0.5
DURATION = 0.6


def dropped(**options: object) -> lf.Scene:
    """A disc above a floor."""
    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    disc = scene.add(lf.Disc(radius=RADIUS, mass=1.0), name="disc", position=(0.0, RADIUS + HEIGHT))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(disc.surface(), floor, restitution=BOUNCE, name="floor", **options)  # type: ignore[arg-type]
    return scene


def height(t: np.ndarray) -> np.ndarray:
    """Of the lowest point, exactly."""
    found = HEIGHT - 0.5 * GRAVITY * t**2
    begin, speed = np.sqrt(2.0 * HEIGHT / GRAVITY), BOUNCE * np.sqrt(2.0 * GRAVITY * HEIGHT)
    while speed > 1e-6:
        since = t - begin
        found = np.where(since > 0.0, speed * since - 0.5 * GRAVITY * since**2, found)
        begin, speed = begin + 2.0 * speed / GRAVITY, BOUNCE * speed
    return np.where(t > begin, 0.0, found)


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=2e-3), lf.GeneralizedAlpha(step=2e-3)])
def test_error_covers_the_truth_of_a_bouncing_ball(stepper: object) -> None:
    result = lf.simulate(dropped(), DURATION, stepper, verify=True)  # type: ignore[arg-type]
    error = result.error
    assert error is not None
    off = np.abs(result.q[:, 1] - RADIUS - height(result.times))
    assert off.max() <= error.place <= 4.0 * off.max()
    assert (off[np.searchsorted(result.times, error.times)] <= error.place_curve[:, 0] + 1e-12).mean() > 0.95
    assert error.whole
    assert error.horizon == result.times[-1]
    assert [run.what for run in error.reruns] == ["a quarter of the step", "another method"]
    assert error.extent == pytest.approx(HEIGHT, rel=0.05)
    assert error.impulse["floor"] > 0.0


def test_event_driven_run_is_checked_by_itself() -> None:
    result = lf.simulate(dropped(), DURATION, lf.EventDriven(rtol=1e-6))
    assert result.error is None
    error = result.verify()
    assert error is result.error
    assert np.abs(result.q[:, 1] - RADIUS - height(result.times)).max() <= error.place + 1e-9
    assert error.place < 1e-9
    assert [run.what for run in error.reruns] == ["a hundredth of the tolerance"]


def test_velocities_near_impacts_are_left_out() -> None:
    result = lf.simulate(dropped(), 0.4, lf.MoreauJean(step=2e-3), verify=True)
    assert result.error is not None
    jump = (1.0 + BOUNCE) * np.sqrt(2.0 * GRAVITY * HEIGHT)
    assert result.error.speed < 0.1 * jump  # 2 x (e + 1) g h / 2 where an impact is half a step late
    assert result.error.speed_rms > result.error.speed


def test_runs_that_part_have_a_horizon() -> None:
    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    upper = scene.add(lf.Box(width=1.0, height=0.1, mass=1.0), name="upper", position=(0.5, 0.0))
    lower = scene.add(lf.Box(width=1.0, height=0.1, mass=1.0), name="lower", position=(1.5, 0.0))
    scene.join(lf.Revolute(upper.at(-0.5, 0.0), scene.ground.at(0.0, 0.0)))
    scene.join(lf.Revolute(lower.at(-0.5, 0.0), upper.at(0.5, 0.0)))
    error = lf.simulate(scene, 8.0, lf.MoreauJean(step=0.02)).verify()
    assert not error.whole
    assert 0.0 < error.horizon < 8.0
    row = np.searchsorted(error.times, error.horizon, side="right")
    off = error.place_curve[row - 1] + error.turn_curve[row - 1]
    assert off.max() <= PARTED * error.extent
    assert (error.place_curve[row] + error.turn_curve[row]).max() > PARTED * error.extent
    assert error.parted == "the runs part"  # nothing touches
    assert error.up_to(error.horizon).place_share <= PARTED < error.place_share + error.turn_share


def test_saved_error_comes_back_and_file_can_be_verified(tmp_path: Path) -> None:
    stepper = lf.EventDriven(rtol=1e-6)
    result = lf.simulate(dropped(), 0.3, stepper, verify=True)
    assert result.error is not None
    result.save(tmp_path / "run.npz")
    loaded = lf.Result.load(tmp_path / "run.npz")
    assert loaded.error is not None
    assert loaded.error.place == result.error.place
    assert loaded.error.reruns == result.error.reruns
    with pytest.raises(lf.ModelError, match="stepper: None was given for a result of a file"):
        loaded.verify()
    with pytest.raises(lf.ModelError, match="expected the one it was run with"):
        loaded.verify(stepper=lf.EventDriven(rtol=1e-5))
    assert loaded.verify(stepper=stepper).place == pytest.approx(result.error.place, abs=1e-12)
    assert loaded.verify(dropped(), stepper).place == pytest.approx(result.error.place, abs=1e-12)
    other = lf.Scene(gravity=(0.0, -GRAVITY))
    for name in ("a", "b"):
        other.add(lf.Disc(radius=RADIUS, mass=1.0), name=name)
    with pytest.raises(lf.ModelError, match="scene: one with 6 coordinates"):
        loaded.verify(other, stepper)
    assert pickle.loads(pickle.dumps(result)).origin is None


def test_another_scene_of_the_same_size_is_refused(tmp_path: Path) -> None:
    stepper = lf.MoreauJean(step=1e-3)
    lf.simulate(dropped(), 0.3, stepper).save(tmp_path / "run.npz")
    scene = lf.Scene(gravity=(0.0, -2.0 * GRAVITY))
    scene.add(lf.Disc(radius=RADIUS, mass=1.0), name="disc", position=(0.0, RADIUS + HEIGHT))
    with pytest.raises(lf.ModelError, match="another scene was given"):
        lf.Result.load(tmp_path / "run.npz").verify(scene, stepper)


def test_function_with_a_memory_is_refused() -> None:
    calls = []

    def push(time: float) -> tuple[float, float]:
        calls.append(time)
        return (1e-2 * len(calls), 0.0)

    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    disc = scene.add(lf.Disc(radius=RADIUS, mass=1.0), name="disc", position=(0.0, 1.0))
    scene.load(lf.Force(disc.at(0.0, 0.0), push))
    result = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3))
    with pytest.raises(lf.ModelError, match="answers otherwise than in the run"):
        result.verify()
    assert result.error is None


@pytest.mark.parametrize(("verify", "measured"), [(False, False), (True, True), ("auto", True)])
def test_simulate_verifies_where_asked(verify: object, measured: bool) -> None:
    result = lf.simulate(dropped(), 0.3, lf.MoreauJean(step=1e-3), verify=verify)  # type: ignore[arg-type]
    assert (result.error is not None) == measured


@pytest.mark.parametrize("verify", [None, 1, "yes"])
def test_simulate_refuses_other_values_of_verify(verify: object) -> None:
    with pytest.raises(lf.ModelError, match=r"verify: .* expected True, False or 'auto'"):
        lf.simulate(dropped(), 0.3, lf.MoreauJean(step=1e-3), verify=verify)  # type: ignore[arg-type]


def test_verification_in_space_measures_rotations() -> None:
    scene = lf.SpatialScene()
    cuboid = lf.Cuboid(0.1, 0.2, 0.4, mass=1.0)
    scene.add(cuboid, name="body", angular_velocity=(0.1, 5.0, 0.1))
    result = lf.simulate(scene, 1.0, lf.MoreauJean(step=5e-3), verify=True)
    error = result.error
    assert error is not None
    exact = lf.simulate(scene, 1.0, lf.EventDriven(rtol=1e-11), record=5e-3)
    turned = result.orientation("body").inv() * exact.orientation("body")
    angle = float(turned.magnitude().max())
    reach = 0.5 * float(np.linalg.norm((0.1, 0.2, 0.4)))
    assert angle * reach <= error.turn * 1.01
    assert error.turn <= 4.0 * angle * reach
    assert error.place < 1e-9


def test_few_instants_are_told() -> None:
    result = lf.simulate(dropped(), DURATION, lf.MoreauJean(step=1e-3), record=0.2, verify=True)
    assert result.error is not None
    assert any("compared at the 4 instants" in note for note in result.error.notes)


@pytest.mark.parametrize(
    ("stepper", "runs"),
    [
        (
            lf.MoreauJean(step=1e-3, adaptive=lf.AdaptiveStep(rtol=1e-4)),
            ["a sixteenth of the tolerance", "another method"],
        ),
        (lf.Smooth(lf.Penalty(1e4)), ["a hundredth of the tolerance"]),
        (lf.Smooth(lf.Penalty(1e4), integrator=lf.Verlet(1e-4)), ["a quarter of the step", "half the step"]),
    ],
)
def test_other_steppers_are_checked(stepper: object, runs: list[str]) -> None:
    error = lf.simulate(dropped(), 0.3, stepper, verify=True).error  # type: ignore[arg-type]
    assert error is not None
    assert [run.what for run in error.reruns] == runs
    assert 0.0 < error.place < 0.01 * error.extent


def test_impact_between_instants_is_no_error_of_velocities() -> None:
    """Controlled steps end where they will: a jump in between is not halved."""
    scene = dropped()
    scene.load(lf.Force(scene.body("disc").at(0.0, 0.0), (0.0, lf.Harmonic(2.0, 80.0))))
    one, other = (
        lf.simulate(scene, 0.4, lf.MoreauJean(step=1e-3, adaptive=lf.AdaptiveStep(rtol=rtol)))
        for rtol in (1e-5, 1e-5 / 16.0)
    )
    jump = (1.0 + BOUNCE) * np.sqrt(2.0 * GRAVITY * HEIGHT)
    apart = differences(one, other, bodies_of(one), 0.0)
    assert apart.rms[0] < 1e-2 * jump * np.sqrt(1e-3)  # of a half of it at one of a thousand instants


def test_step_that_a_stepper_chose_is_divided() -> None:
    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    beam = lf.Beam(0.5, 0.05, 0.02, 7800.0, 2.1e11, elements=4, axial=False)
    placed = scene.add(beam, "beam", position=(0.0, 0.1), modes=2)
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(placed.surface(), floor, name="floor")
    result = lf.simulate(scene, 5e-3, lf.MasslessBoundary())
    error = result.verify()
    assert [run.what for run in error.reruns[:2]] == ["a quarter of the step", "half the step"]
    assert error.reruns[0].steps == pytest.approx(4 * result.steps, rel=0.01)


def test_user_system_is_measured_in_shares_of_its_ranges() -> None:
    system = lf.UserSystem(
        q=[HEIGHT],
        u=[0.0],
        mass=np.eye(1),
        force=lambda t, q, u: np.array([-GRAVITY]),
        gaps=lambda q: np.array([q[0]]),
        normals=np.eye(1),
        restitution=BOUNCE,
    )
    result = lf.simulate(system, DURATION, lf.MoreauJean(step=2e-3), verify=True)
    error = result.error
    assert error is not None
    off = np.abs(result.q[:, 0] - height(result.times)).max() / np.ptp(result.q)
    assert off <= error.place <= 4.0 * off
    assert error.extent == error.fastest == 1.0


def test_resumed_run_can_be_verified(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    whole = lf.simulate(dropped(), 0.3, lf.MoreauJean(step=2e-3), checkpoint=path)
    assert lf.resume(path).verify().place == whole.verify().place


def falling_bar(modes: int) -> lf.Scene:
    """A bar that falls on a wall end on: with few modes it keeps too much of its energy."""
    scene = lf.Scene()
    bar = lf.Bar(length=1.0, area=1e-4, density=7800.0, youngs_modulus=2.1e11)
    body = scene.add(bar, name="bar", modes=modes, position=(2e-4, 0.0), velocity=(-1.0, 0.0))
    scene.contact(body.node(0.0, 0.0), scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)), restitution=0.0, name="wall")
    return scene


def test_modes_are_part_of_the_error() -> None:
    stepper = lf.MoreauJean(step=1e-6)
    few, rich = (lf.simulate(falling_bar(modes), 2e-3, stepper) for modes in (2, 32))
    error = few.verify()
    assert error.reruns[-1].what == "twice as many modes"
    assert error.modes is not None
    ends = ("left", "right")
    off = max(np.abs(few.point("bar", end) - rich.point("bar", end)).max() for end in ends)
    assert 0.5 * off <= error.modes <= 4.0 * off
    assert error.modes > error.place  # the modes err more than the steps


def test_modes_are_told_where_they_cannot_be_doubled() -> None:
    result = lf.simulate(falling_bar(2), 1e-3, lf.MoreauJean(step=1e-6))
    again = lf.simulate(falling_bar(2), 1e-4, lf.MoreauJean(step=1e-6), initial=result, verify=True)
    assert again.error is not None
    assert again.error.modes is None
    assert "began from the state of another" in again.error.modes_note


def test_rounding_of_a_body_at_rest_is_no_error() -> None:
    """Without an outline, and with a motion of 1e-16 m: shares are of its radius of gyration."""
    scene = lf.Scene(gravity=(0.0, -GRAVITY))
    body = scene.add(lf.RigidBody(mass=1.0, inertia=1.0), name="weight", position=(0.1, -GRAVITY / 100.0))
    scene.load(lf.Spring(body.at(0.0, 0.0), scene.ground.at(0.1, 1.0), stiffness=100.0, length=1.0))
    result = lf.simulate(scene, 0.2, lf.MoreauJean(step=1e-3), verify=True)
    assert result.error is not None
    assert result.error.extent == 1.0
    assert result.error.whole
    assert result.verdict.word == "Trusted"
