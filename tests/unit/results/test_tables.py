"""Results in pandas and xarray: numbers by label, units, facts of the run, and files that come back equal."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.basics import libs
from lcpflex.basics.version import VERSION
from lcpflex.errors import ModelError
from lcpflex.results.result import SLIP, Result
from tests.scenes import disc_on_floor

ENGINES = [
    pytest.param(name, marks=pytest.mark.skipif(find_spec(name) is None, reason=f"needs {name}"))
    for name in ("h5netcdf", "scipy")
]


@pytest.fixture(scope="module")
def struck() -> Result:
    """A disc and a pendulum, event-driven: the disc lands twice at least, instants of events are stored twice."""
    scene = disc_on_floor(0.15, (1.0, 0.0), friction=0.3, restitution=0.5)
    bar = scene.add(lf.Box(0.4, 0.05, mass=1.0), name="bar", position=(2.0, 1.0))
    scene.join(lf.Revolute(bar.at(-0.1, 0.0), scene.ground.at(1.9, 1.0), name="hinge"))
    return lf.simulate(scene, 0.4, lf.EventDriven(), record=5e-3, progress=False)


@pytest.fixture(scope="module")
def free() -> Result:
    """Nothing to touch, no joint, and steps that are stored densely."""
    scene = lf.Scene()
    scene.add(lf.Disc(0.1, mass=1.0), name="Räder 1")
    return lf.simulate(scene, 0.1, lf.EventDriven(), record="dense", progress=False)


@pytest.fixture
def of_file(bounce: Result) -> Result:
    """As read from a file of an older version, of a run that stopped: what it did not know is None."""
    return replace(bounce, complete=False, message="a callback raised", warnings=("one", "two"), strict=None)


@pytest.fixture(params=["struck", "free", "swing", "bounce", "of_file", "sensed"])
def any_result(request: pytest.FixtureRequest) -> Any:
    return request.getfixturevalue(request.param)


def test_dataset_has_the_numbers_by_label(struck: Result) -> None:
    pytest.importorskip("xarray")
    found, k = struck.to_xarray(), struck.contact_names.index("floor")
    np.testing.assert_array_equal(found.q.sel(coordinate="disc.y"), struck.point("disc", "center")[:, 1])
    np.testing.assert_array_equal(found.force.sel(contact="floor", component="normal"), struck.force[:, k, 0])
    np.testing.assert_array_equal(found.gap.sel(contact="floor"), struck.gap[:, k])
    hinge = struck.reaction("hinge")
    np.testing.assert_array_equal(found.joint_force.sel(joint="hinge", axis="y"), hinge.force[:, 1])
    np.testing.assert_array_equal(found.joint_moment.sel(joint="hinge"), hinge.moment)
    np.testing.assert_array_equal(found.joint_unique.sel(joint="hinge"), hinge.unique)
    np.testing.assert_array_equal(found.energy_kinetic, struck.energies.kinetic)


def test_dataset_has_touching_points_and_events(struck: Result) -> None:
    pytest.importorskip("xarray")
    found = struck.to_xarray()
    assert found.sizes["touch"] == len(struck.contact_points.record) > 10
    times = struck.times[found.touch_time_index]
    at = struck.contact_points.at(int(found.touch_time_index[-1]))
    np.testing.assert_array_equal(found.touch_place[times == times[-1]], at.place)
    assert list(found.event_time.values) == [event.time for event in struck.events]
    assert list(found.event_kind.values) == [event.kind for event in struck.events]
    impact = float(found.event_time[0])
    before, after = found.u.sel(time=impact, coordinate="disc.y").values
    assert after == pytest.approx(-0.5 * before, rel=1e-12)
    assert before < 0.0


def test_units_are_told(struck: Result, swing: Result, bounce: Result) -> None:
    pytest.importorskip("xarray")
    found = struck.to_xarray()
    units = {name: found[name].attrs.get("units") for name in ("time", "force", "impulse", "gap", "joint_moment")}
    assert units == {"time": "s", "force": "N", "impulse": "N s", "gap": "m", "joint_moment": "N m"}
    assert found.q_units.sel(coordinate="disc.angle") == "rad"
    assert found.u_units.sel(coordinate="disc.angle") == "rad/s"
    assert swing.to_xarray().u_units.sel(coordinate="pendulum.mode 1") == "kg^0.5 m/s"
    assert set(bounce.to_xarray().q_units.values) == {"unknown"}
    without = {name for name, one in found.data_vars.items() if "units" not in one.attrs}
    assert without == {"state", "touch_state", "event_kind", "event_contact"}
    assert found.state.attrs["flag_meanings"].split()[SLIP] == "slip"


def test_facts_of_the_run_are_told(of_file: Result) -> None:
    pytest.importorskip("xarray")
    told = of_file.to_xarray().attrs
    assert told["complete"] == 0
    assert told["message"] == "a callback raised"
    assert told["warnings"] == "one\ntwo"
    assert told["stepper"] == of_file.stepper
    assert told["duration"] == 0.5
    assert told["lcpflex"] == VERSION
    assert "strict" not in of_file.to_xarray()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("engine", ENGINES)
def test_netcdf_comes_back_equal(any_result: Result, engine: str, tmp_path: Path) -> None:
    """NaN, truth values, empty and foreign texts, what is None, what there is none of."""
    xarray = pytest.importorskip("xarray")
    found = any_result.to_xarray()
    found.to_netcdf(tmp_path / "result.nc", engine=engine)
    with xarray.open_dataset(tmp_path / "result.nc", engine=engine) as back:
        xarray.testing.assert_equal(back, found)
        assert back.attrs == found.attrs
        assert all(back[name].attrs.get("units") == found[name].attrs.get("units") for name in found.variables)
        if "joint_unique" in found:
            assert back.joint_unique.dtype == bool


def test_table_has_units_and_facts(any_result: Result) -> None:
    pytest.importorskip("pandas")
    table = any_result.to_dataframe()
    assert set(table.attrs["units"]) == {"time", *table.columns}
    assert table.attrs["stepper"] == any_result.stepper
    assert len(table) == len(any_result.times)


def test_table_keeps_both_rows_of_an_event(struck: Result) -> None:
    pytest.importorskip("pandas")
    table = struck.to_dataframe()
    before, after = table.loc[struck.events[0].time, "disc.y'"]
    assert after == pytest.approx(-0.5 * before, rel=1e-12)
    assert table.attrs["units"]["hinge.moment"] == "N m"
    assert table.attrs["units"]["floor.normal impulse"] == "N s"


@pytest.mark.parametrize(("package", "work"), [("pandas", Result.to_dataframe), ("xarray", Result.to_xarray)])
def test_without_the_package(
    bounce: Result, monkeypatch: pytest.MonkeyPatch, package: str, work: Callable[[Result], Any]
) -> None:
    monkeypatch.setitem(__import__("sys").modules, package, None)
    monkeypatch.delitem(vars(libs), package, raising=False)  # where another test has loaded it
    with pytest.raises(ModelError, match=f"needs {package}, which is not installed: pip install"):
        work(bounce)


@pytest.fixture(scope="module")
def sensed() -> Result:
    """Sensors at rates of their own; one with columns of different units, and a name that netCDF takes for a path."""
    scene = disc_on_floor(0.12, (1.0, 0.0), friction=0.3)
    center = scene.body("disc").point("center")
    scene.sensor(lf.sensors.Point(center, every=0.01, name="centre/path"))
    scene.sensor(lf.sensors.Energy(every=0.004, name="energy"))
    for name in ("centre_path", "energy_time"):
        scene.sensor(lf.sensors.Body("disc", every=0.02, name=name))
    return lf.simulate(scene, 0.08, lf.MoreauJean(step=1e-3), record=0.02, progress=False)


def test_dataset_has_sensors_at_times_of_their_own(sensed: Result) -> None:
    pytest.importorskip("xarray")
    found, path = sensed.to_xarray(), sensed.sensor("centre/path")
    one = found["sensor_centre_path"]
    assert found.sizes["sensor_centre_path_time"] == len(path.times) > found.sizes["time"]
    np.testing.assert_array_equal(one, path.values)
    np.testing.assert_array_equal(one.sensor_centre_path_time, path.times)
    assert one.attrs["long_name"] == "centre/path"
    assert tuple(one.sensor_centre_path_units.values) == path.units
    assert one.attrs["units"] == "see sensor_centre_path_units"
    energy = found["sensor_energy"]
    assert energy.attrs["units"] == "J"
    body = sensed.sensor("centre_path").values  # names that would be those of others
    np.testing.assert_array_equal(found["sensor_centre_path_"], body)
    np.testing.assert_array_equal(found["sensor_energy_time_"], body)
    kinetic = energy.sel(sensor_energy_column="kinetic")
    np.testing.assert_array_equal(kinetic, sensed.sensor("energy").column("kinetic"))


@pytest.mark.parametrize("ending", [".npz", ".h5"])
def test_files_keep_sensors(sensed: Result, ending: str, tmp_path: Path) -> None:
    if ending == ".h5":
        pytest.importorskip("h5py")
    loaded = Result.load(sensed.save(tmp_path / f"sensed{ending}"))
    for one, other in zip(loaded.sensors, sensed.sensors, strict=True):
        assert (one.name, one.columns, one.units) == (other.name, other.columns, other.units)
        np.testing.assert_array_equal(one.times, other.times)
        np.testing.assert_array_equal(one.values, other.values)
