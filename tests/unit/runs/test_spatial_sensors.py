"""Sensors of spatial scenes: what the result tells at the same instants, to the bit. Planar ones are refused."""

from __future__ import annotations

import pickle
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from tests.spatial_scenes import thrown
from tests.unit.runs.checkpoint_runs import assert_same_bits, broken_off
from tests.unit.runs.sensor_scenes import assert_same_result

SLOW, DURATION = 0.0031, 0.04
STEPPERS: dict[str, Any] = {
    "moreau": lf.MoreauJean(step=1e-3),
    "moreau adaptive": lf.MoreauJean(step=1e-3, adaptive=lf.AdaptiveStep(rtol=1e-4)),
    "alpha": lf.GeneralizedAlpha(step=1e-3),
    "event-driven": lf.EventDriven(rtol=1e-6),
}
SENSED = [pytest.param(name, marks=() if name == "moreau" else pytest.mark.slow) for name in STEPPERS]


def weighed(now: Any) -> float:
    """A function of the user's."""
    return float(now.time + now.q.sum() + now.u.sum())


def measured(*every: float | None, own: bool = True) -> lf.SpatialScene:
    """Thrown bodies with a sensor of each kind for each interval."""
    scene, of = thrown(), lf.sensors
    box = scene.body("box")
    for k, each in enumerate(every):
        scene.sensor(of.Point(box.at(0.1, 0.0, 0.05), every=each, name=f"corner {k}"))
        scene.sensor(of.Point(scene.body("soft").point("3"), every=each, name=f"node {k}"))
        scene.sensor(of.Body(box, every=each, name=f"body {k}"))
        scene.sensor(of.Coordinates(("box.omega_z", "soft.mode 2", "box.p0"), every=each, name=f"numbers {k}"))
        scene.sensor(of.Energy(every=each, name=f"energy {k}"))
        if own:
            scene.sensor(of.Function(weighed, every=each, name=f"own {k}"))
    return scene


@pytest.mark.parametrize("name", SENSED)
def test_a_sensor_tells_what_a_record_at_its_rate_would_and_leaves_no_trace(name: str) -> None:
    at_rate = lf.simulate(measured(SLOW), DURATION, STEPPERS[name], record=0.0007)
    record = lf.simulate(measured(None), DURATION, STEPPERS[name], record=SLOW)
    for one, other in zip(at_rate.sensors, record.sensors, strict=True):
        np.testing.assert_array_equal(one.times, other.times, one.name)
        np.testing.assert_array_equal(one.values, other.values, one.name)
    compare_with_result(record)
    assert_same_result(lf.simulate(measured(), DURATION, STEPPERS[name], record=0.0007), at_rate)


def compare_with_result(result: lf.Result) -> None:
    def same(name: str, *expected: Any) -> None:
        np.testing.assert_array_equal(result.sensor(f"{name} 0").values, np.column_stack(expected), name)

    corner = (0.1, 0.0, 0.05)
    same("corner", result.point("box", corner), result.velocity("box", corner))
    same("node", result.point("soft", "3"), result.velocity("soft", "3"))
    numbers = {name: result.q[:, k] for k, name in enumerate(result.coordinate_names())}
    rates = {name: result.u[:, k] for k, name in enumerate(result.velocity_names())}
    frame = [numbers[f"box.{part}"] for part in ("x", "y", "z", "p0", "p1", "p2", "p3")]
    same("body", *frame, *(rates[f"box.v_{axis}"] for axis in "xyz"), result.angular_velocity("box"))
    same("numbers", numbers["soft.mode 2"], numbers["box.p0"], rates["box.omega_z"], rates["soft.mode 2"])
    same("own", [t + q.sum() + u.sum() for t, q, u in zip(result.times, result.q, result.u, strict=True)])
    stored = ("kinetic", "elastic", "potential", "friction", "impact", "damping", "work")
    same("energy", *(getattr(result.energies, name) for name in stored))


def test_columns_have_names_and_units() -> None:
    result = lf.simulate(measured(None), 0.002, STEPPERS["moreau"])
    numbers, body, corner = (result.sensor(f"{name} 0") for name in ("numbers", "body", "corner"))
    assert numbers.columns == ("soft.mode 2", "box.p0", "box.omega_z", "soft.mode 2'")
    assert numbers.units == ("kg^0.5 m", "1", "rad/s", "kg^0.5 m/s")
    assert corner.columns == ("x", "y", "z", "velocity x", "velocity y", "velocity z")
    assert corner.units == ("m", "m", "m", "m/s", "m/s", "m/s")
    assert body.columns[3:7] == ("p0", "p1", "p2", "p3")
    assert body.units[10:] == ("rad/s",) * 3
    np.testing.assert_array_equal(body.column("angular velocity y"), result.angular_velocity("box")[:, 1])
    np.testing.assert_allclose(np.linalg.norm(body.values[:, 3:7], axis=1), 1.0, rtol=1e-14)


def test_functions_are_asked_with_rotations() -> None:
    scene = thrown("box")
    box = scene.body("box")

    def told(now: Any) -> Any:
        whole = *now.position(box.at(0.1, 0, 0)), *now.velocity(box.at(0.1, 0, 0)), *now.angular_velocity(box)
        return [*whole, *now.rotation(box).ravel()]

    scene.sensor(lf.sensors.Function(told, columns=tuple(map(str, range(18)))))
    result = lf.simulate(scene, 0.02, STEPPERS["moreau"])
    axes = result.orientation("box").as_matrix().reshape(-1, 9)
    place = (0.1, 0.0, 0.0)
    expected = result.point("box", place), result.velocity("box", place), result.angular_velocity("box"), axes
    np.testing.assert_allclose(result.sensors[0].values, np.column_stack(expected), rtol=0.0, atol=1e-14)
    scene.sensor(lf.sensors.Function(lambda now: now.angle(box)))
    with pytest.raises(ModelError, match=r"bodies in space have no one angle; expected rotation\(of\)"):
        lf.simulate(scene, 0.02, STEPPERS["moreau"])


@pytest.mark.parametrize(
    ("sensor", "words"),
    [
        (lf.sensors.Body("bx"), "body: no body 'bx'"),
        (lf.sensors.Coordinates(("box.angle",)), "names: no coordinate or velocity 'box.angle'"),
        (lf.sensors.Reaction("hinge"), "joint: no joint 'hinge'"),
    ],
)
def test_what_cannot_be_measured_in_space_is_refused_by_name(sensor: Any, words: str) -> None:
    scene = thrown("box")
    scene.sensor(sensor)
    with pytest.raises(ModelError, match=f"sensor 'sensor1': {words}"):
        scene.compile()


@pytest.mark.parametrize(
    ("body", "x", "words"),
    [
        ("box", 0.0, "body: 'box' was given, expected a SpatialBeam"),
        ("rod", 0.0, "body: no body 'rod'"),
        ("beam", 0.4, "x: 0.4 was given, expected a place from -0.3 to 0.3 m"),
    ],
)
def test_sections_that_are_not_there_are_refused_by_name(body: str, x: float, words: str) -> None:
    scene = thrown("box")
    scene.add(slender().reduce(0), "beam", (0.0, 0.0, 5.0))
    scene.sensor(lf.sensors.Section(body, x))
    with pytest.raises(ModelError, match=f"sensor 'sensor1': {words}"):
        lf.simulate(scene, 0.02, STEPPERS["moreau"])


def slender() -> lf.SpatialBeam:
    return lf.SpatialBeam(0.6, 1e-4, (8e-10, 1.6e-9), 2.4e-9, 2700.0, 7e10, poissons_ratio=0.3, elements=10)


def test_sections_of_a_beam_that_touches_are_those_of_the_result() -> None:
    scene = lf.SpatialScene()
    beam = scene.add(slender().reduce(0), "beam")
    rod = beam.capsule("left", "right", 0.01)
    for k, x in enumerate((-0.2, 0.25)):
        scene.contact(rod, scene.ground.sphere((x, 0.0, -0.06), 0.05), friction=0.2, name=f"support {k}")
    scene.sensor(lf.sensors.Section(beam, 0.1, every=2e-3, name="cut"))
    scene.sensor(lf.sensors.Section("beam", -0.2))
    result = lf.simulate(scene, 0.02, STEPPERS["moreau"], record=2e-3)
    cut = result.sensor("cut")
    assert cut.columns == ("N", "V_y", "V_z", "T", "M_y", "M_z", "unique")
    assert cut.units == ("N", "N", "N", "N m", "N m", "N m", "")
    for sensor, x in zip(result.sensors, (0.1, -0.2), strict=True):
        found = result.section("beam", x)
        for name in sensor.columns:
            np.testing.assert_array_equal(sensor.column(name), getattr(found, name))
    assert np.abs(cut.column("V_z")).max() > 0.1


def test_rotations_are_refused_in_the_plane_by_name() -> None:
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0))
    scene.sensor(lf.sensors.Function(lambda now: now.rotation(disc)))
    with pytest.raises(ModelError, match=r"bodies of a planar scene have one angle; expected angle\(of\)"):
        lf.simulate(scene, 0.01, STEPPERS["moreau"])


@pytest.mark.parametrize("name", SENSED)
def test_a_resumed_run_has_the_bits_of_one_that_was_not_broken_off(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def build() -> lf.SpatialScene:
        return measured(SLOW, own=False)

    whole = lf.simulate(build(), 0.1, STEPPERS[name])
    broken_off(tmp_path / "run.npz", monkeypatch, build, STEPPERS[name])
    assert_same_bits(whole, lf.resume(tmp_path / "run.npz"))


def test_copies_and_pickles_of_a_scene_run_to_the_same_bits() -> None:
    scene = measured(SLOW, own=False)
    whole = lf.simulate(scene, 0.02, STEPPERS["moreau"])
    for again in (deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert again.body("box").scene is again
        assert_same_bits(whole, lf.simulate(again, 0.02, STEPPERS["moreau"]))
        again.add(lf.Sphere(0.1, mass=1.0), "more")
    assert len(scene.parts().placed) == 3
    compiled = pickle.loads(pickle.dumps(scene.compile()))
    np.testing.assert_array_equal(compiled.model.bodies.second, scene.compile().model.bodies.second)
    assert not compiled.model.bodies.second.flags.writeable


def test_a_run_starts_from_the_last_state_of_another() -> None:
    first = lf.simulate(thrown(), 0.02, STEPPERS["moreau"])
    second = lf.simulate(thrown(), 0.03, STEPPERS["moreau"], initial=first)
    whole = lf.simulate(thrown(), 0.05, STEPPERS["moreau"])
    np.testing.assert_array_equal(second.q[-1], whole.q[-1])
    np.testing.assert_array_equal(second.u[-1], whole.u[-1])
    with pytest.raises(ModelError, match="initial: a Result with the coordinates"):
        lf.simulate(thrown("box"), 0.01, STEPPERS["moreau"], initial=first)


def test_reactions_have_six_components_and_energies_count_the_work_of_torques() -> None:
    """A ball on a hinge about z under a torque about z and one about x, which the hinge takes."""
    scene = lf.SpatialScene()
    ball = scene.add(lf.Sphere(0.1, mass=1.0), "ball")
    hinge = lf.Revolute(ball.point("center"), scene.ground.at(0, 0, 0), axis=(0, 0, 1), name="hinge")
    scene.join(hinge)
    scene.load(lf.Torque(ball.point("center"), (0.3, 0.0, 0.02)))
    scene.sensor(lf.sensors.Reaction("hinge", every=0.013, name="r"))
    scene.sensor(lf.sensors.Energy(every=0.013, name="e"))
    result = lf.simulate(scene, 0.1, STEPPERS["moreau"])
    history, energy = result.sensor("r"), result.sensor("e")
    assert history.columns[:6] == ("force x", "force y", "force z", "moment x", "moment y", "moment z")
    reaction = result.reaction("hinge")
    np.testing.assert_allclose(reaction.force[1:], np.tile([0.0, 0.0, 9.81], (len(result.times) - 1, 1)), atol=1e-9)
    np.testing.assert_allclose(
        history.values[1:, :6], [[0.0, 0.0, 9.81, -0.3, 0.0, 0.0]] * (len(history.times) - 1), atol=1e-9
    )
    J = 0.4 * 0.1**2
    np.testing.assert_allclose(energy.column("work"), (0.02 * energy.times) ** 2 / (2.0 * J), rtol=1e-9, atol=1e-15)
    np.testing.assert_allclose(energy.column("kinetic"), energy.column("work"), rtol=1e-9, atol=1e-15)
    assert result.energies.largest_remainder < 1e-14
