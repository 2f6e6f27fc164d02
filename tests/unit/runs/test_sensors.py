"""Sensors measure at rates of their own what a record at that rate would tell, and leave no trace in the run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.scenes import disc_on_floor
from tests.unit.runs.checkpoint_runs import RUNS
from tests.unit.runs.sensor_scenes import DURATION, SLOW, STEPPERS, assert_same_result, kinds, struck_beam

QUICK = ("moreau", "event-driven", "verlet")
SENSED = [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in STEPPERS]


@pytest.mark.parametrize("name", SENSED)
def test_a_run_with_sensors_is_the_run_without_them(name: str) -> None:
    without = lf.simulate(struck_beam(), DURATION, STEPPERS[name], record=0.0007)
    with_sensors = lf.simulate(struck_beam(SLOW, 0.001), DURATION, STEPPERS[name], record=0.0007)
    assert_same_result(without, with_sensors)
    assert without.impulse[-1, 0, 0] > 0.0
    assert len(with_sensors.sensor("tip 0").times) < len(with_sensors.sensor("tip 1").times) < len(without.times)


@pytest.mark.parametrize("name", SENSED)
def test_a_sensor_tells_what_a_record_at_its_rate_would(name: str) -> None:
    at_rate = lf.simulate(struck_beam(SLOW), DURATION, STEPPERS[name], record=0.0007)
    record = lf.simulate(struck_beam(None), DURATION, STEPPERS[name], record=SLOW)
    for one, other in zip(at_rate.sensors, record.sensors, strict=True):
        np.testing.assert_array_equal(one.times, other.times, one.name)
        np.testing.assert_array_equal(one.values, other.values, one.name)
    compare_with_result(record)


def compare_with_result(result: lf.Result) -> None:
    """The sensors that measured with the record, against what the result tells; sections and stresses by rounding."""

    def same(name: str, *expected: Any) -> None:
        np.testing.assert_array_equal(result.sensor(f"{name} 0").values, np.column_stack(expected), name)

    same("tip", result.point("bar", "right"), result.velocity("bar", "right"))
    same("body", result.q[:, :3], result.u[:, :3])
    same("modes", result.q[:, [4, 2]], result.u[:, [4, 2]])
    stored = ("kinetic", "elastic", "potential", "friction", "impact", "damping", "work")
    same("energy", *(getattr(result.energies, name) for name in stored))
    contact = result.contact("stop")
    same("stop", contact.force, contact.impulse, contact.gap, contact.state)
    for name, axes in (("hinge", "world"), ("turned", "body")):
        r = result.reaction("hinge", axes)
        rest = (r.largest_force, r.largest_moment, r.impulse, r.angular_impulse, np.full(len(r.times), np.nan))
        same(name, r.force, r.moment, *rest, r.unique)
    at = [result.q[k] @ result.u[k] + t for k, t in enumerate(result.times)]
    np.testing.assert_array_equal(result.sensor("own 0").column("a"), at)
    section = result.section("bar", 0.2)
    for name in ("N", "V", "M"):
        np.testing.assert_allclose(result.sensor("section 0").column(name), getattr(section, name), rtol=1e-12)
    stress = result.stress("bar")
    k = int(np.hypot(*(stress.places - (0.25, 0.005)).T).argmin())
    np.testing.assert_allclose(result.sensor("stress 0").column("xx"), stress.all().xx[:, k], rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "record"),
    [
        ("event-driven", "dense"),
        ("moreau", None),
        *(pytest.param("event-driven", record, marks=pytest.mark.slow) for record in (0.0, None)),
        *(pytest.param("moreau", record, marks=pytest.mark.slow) for record in ("dense", 0.0)),
    ],
)
def test_beside_a_record_of_everything(name: str, record: Any) -> None:
    without = lf.simulate(struck_beam(), DURATION, STEPPERS[name], record=record)
    result = lf.simulate(struck_beam(0.0, 0.002, None, costly=False), DURATION, STEPPERS[name], record=record)
    assert_same_result(without, result)
    each = lf.simulate(struck_beam(None, costly=False), DURATION, STEPPERS[name], record=0)
    np.testing.assert_array_equal(result.sensor("tip 0").values, each.sensor("tip 0").values)
    assert len(result.sensor("tip 2").times) == len(result.times)


@pytest.mark.parametrize("name", ["moreau", "alpha"])
def test_a_pile_under_a_rule_is_the_same_with_sensors(name: str) -> None:
    build, _, stepper = RUNS[name]
    without, scene = lf.simulate(build(), 0.1, stepper, record=0.007), build()
    for every in (0.0, 0.0013, 0.02):
        scene.sensor(lf.sensors.Contact(without.contact_names[0], every=every))
    scene.sensor(lf.sensors.Function(lambda now: now.force.sum(), every=0.01))
    assert_same_result(without, lf.simulate(scene, 0.1, stepper, record=0.007))


def test_both_sides_of_an_event_are_measured() -> None:
    result = lf.simulate(disc_with_sensor(every=1.0), 0.5, lf.EventDriven(), record=0.5)
    height = result.sensor("height")
    t = np.sqrt(2.0 * 1.0 / 9.81)
    twice = np.flatnonzero(np.diff(height.times) == 0.0)
    assert height.times[twice[0]] == pytest.approx(t, rel=1e-9)
    speed = np.sqrt(2.0 * 9.81 * 1.0)
    assert height.column("velocity y")[twice[0] : twice[0] + 2] == pytest.approx([-speed, 0.5 * speed], rel=1e-8)


def disc_with_sensor(**given: Any) -> lf.Scene:
    scene = disc_on_floor(1.1, restitution=0.5)
    scene.sensor(lf.sensors.Point(scene.body("disc").point("center"), name="height", **given))
    return scene


def test_memory_holds_what_was_asked_for() -> None:
    scene = disc_with_sensor(every=1e-3)
    result = lf.simulate(scene, 0.4, lf.MoreauJean(step=1e-4), record=0.1)
    assert len(result.times) == 5
    assert result.sensor("height").values.shape == (401, 4)
    t = result.sensor("height").times
    np.testing.assert_allclose(result.sensor("height").column("y"), 1.1 - 0.5 * 9.81 * t**2, atol=1e-9)


def test_saved_and_read(tmp_path: Path) -> None:
    result = lf.simulate(struck_beam(0.002), DURATION, STEPPERS["moreau"])
    again = lf.Result.load(result.save(tmp_path / "run.npz"))
    for one, other in zip(result.sensors, again.sensors, strict=True):
        np.testing.assert_array_equal(one.values, other.values)
        np.testing.assert_array_equal(one.times, other.times)
        assert (one.name, one.columns, one.units) == (other.name, other.columns, other.units)
    assert "sensors: unasked: " in result.summary()
    pandas = pytest.importorskip("pandas")
    frame = again.sensor("tip 0").to_dataframe()
    assert isinstance(frame, pandas.DataFrame)
    assert frame.attrs["units"]["velocity x"] == "m/s"
    assert frame["y"].iloc[-1] == result.point("bar", "right")[-1, 1]


@pytest.mark.slow
def test_a_million_values_in_a_file_of_their_size(tmp_path: Path) -> None:
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(0.1, mass=1.0), "disc", velocity=(0.1, 0.3), angular_velocity=1.1)
    for _ in range(10):
        scene.sensor(lf.sensors.Point(disc.point("center"), every=0.0))
    result = lf.simulate(scene, 2.5, lf.MoreauJean(step=1e-4))
    numbers = sum(sensor.values.nbytes for sensor in result.sensors)
    assert numbers == 10 * 25001 * 4 * 8  # a million, of 8 bytes
    rest = lf.Result.load(lf.simulate(lf_without(scene), 2.5, lf.MoreauJean(step=1e-4)).save(tmp_path / "rest.npz"))
    size = result.save(tmp_path / "run.npz").stat().st_size - (tmp_path / "rest.npz").stat().st_size
    assert size <= 1.03 * numbers
    assert not rest.sensors


def lf_without(scene: lf.Scene) -> lf.Scene:
    """The same bodies without sensors."""
    bare = lf.Scene(gravity=scene.gravity)
    bare.add(lf.Disc(0.1, mass=1.0), "disc", velocity=(0.1, 0.3), angular_velocity=1.1)
    return bare


def test_of_a_system_of_the_users_own() -> None:
    of = lf.sensors
    system = lf.UserSystem(
        q=[0.1], u=[0.0], mass=[[1.0]], force=lambda t, q, u: [-9.81], gaps=lambda q: q, normals=[[1.0]],
        restitution=0.5, names=("floor",),
        sensors=(
            of.Coordinates(("q 1",), every=0.008, name="q"), of.Contact("floor"), of.Energy(every=0.1),
            of.Function(lambda now: now.q[0] ** 2, every=0.0),
        ),
    )  # fmt: skip
    bare = lf.UserSystem(
        q=[0.1], u=[0.0], mass=[[1.0]], force=lambda t, q, u: [-9.81], gaps=lambda q: q, normals=[[1.0]],
        restitution=0.5, names=("floor",),
    )  # fmt: skip
    result = lf.simulate(system, 0.2, lf.MoreauJean(step=4e-3), record=0.02)
    assert_same_result(result, lf.simulate(bare, 0.2, lf.MoreauJean(step=4e-3), record=0.02))
    assert [sensor.name for sensor in result.sensors] == ["q", "sensor1", "sensor2", "sensor3"]
    assert [len(sensor.times) for sensor in result.sensors] == [26, 11, 3, 51]
    np.testing.assert_array_equal(result.sensor("sensor3").values[::5, 0], result.q[:, 0] ** 2)
    np.testing.assert_array_equal(result.sensor("q").values[::5, 0], result.q[::2, 0])


def test_with_other_bodies_they_measure_the_same_places() -> None:
    scene = struck_beam(0.002)
    stiff = lf.Beam(0.5, 0.02, 0.01, 1000.0, 1e10, axial=False).reduce(modes=2)
    result = lf.simulate(scene.with_bodies({"bar": stiff}).with_bodies({}), 0.001, STEPPERS["moreau"])
    assert {sensor.name for sensor in result.sensors} >= {f"{name} 0" for name in kinds(scene.body("bar"))}
    np.testing.assert_array_equal(result.sensor("tip 0").values[-1, :2], result.point("bar", "right")[-1])
