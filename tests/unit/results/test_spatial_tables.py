"""Spatial results in tables and files: numbers by label with units, and files that come back equal."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.spatial.shapes import SphereShape, SurfaceShape
from lcpflex.errors import ModelError
from tests.spatial_scenes import thrown
from tests.unit.runs.checkpoint_runs import assert_same_bits

REFUSED = "is planar so far"


@pytest.fixture(scope="module")
def flight() -> lf.Result:
    return lf.simulate(thrown(), 0.02, lf.MoreauJean(step=1e-3))


def test_a_data_frame_has_a_column_for_each_number_of_q_and_of_u(flight: lf.Result) -> None:
    table = flight.to_dataframe()
    names, rates = flight.coordinate_names(), flight.velocity_names()
    assert len(names) == flight.q.shape[1] == len(rates) + 3
    np.testing.assert_array_equal(table[list(names)].to_numpy(), flight.q)
    labels = [name if name not in names else f"{name}'" for name in rates]
    np.testing.assert_array_equal(table[labels].to_numpy(), flight.u)
    np.testing.assert_allclose(table["ball.omega_z"], 3.0, rtol=1e-14)
    units = table.attrs["units"]
    expected = {"box.p0": "1", "box.omega_x": "rad/s", "box.v_z": "m/s", "soft.mode 1": "kg^0.5 m"}
    assert {name: units[name] for name in expected} == expected
    assert units["soft.mode 1'"] == "kg^0.5 m/s"


def test_labelled_arrays_have_a_dimension_for_q_and_one_for_u(flight: lf.Result, tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    import xarray

    data = flight.to_xarray()
    assert (data["q"].dims, data["u"].dims) == (("time", "coordinate"), ("time", "velocity"))
    np.testing.assert_array_equal(data["u"].sel(velocity="box.omega_y"), flight.u[:, 4])
    np.testing.assert_array_equal(data["q"].sel(coordinate="box.p3"), flight.q[:, 6])
    assert data["u_units"].sel(velocity="soft.mode 3'").item() == "kg^0.5 m/s"
    data.to_netcdf(tmp_path / "flight.nc", engine="h5netcdf")
    with xarray.open_dataset(tmp_path / "flight.nc", engine="h5netcdf") as again:
        np.testing.assert_array_equal(again["u"], flight.u)


@pytest.mark.parametrize("name", ["flight.npz", "flight.h5"])
def test_saved_results_come_back_equal(flight: lf.Result, tmp_path: Path, name: str) -> None:
    if name.endswith("h5"):
        pytest.importorskip("h5py")
    again = lf.Result.load(flight.save(tmp_path / name))
    assert_same_bits(flight, again)
    assert again.compiled is not None
    assert flight.compiled is not None
    assert again.compiled.spatial
    for group, other in zip(again.compiled.model, flight.compiled.model, strict=True):
        assert type(group) is type(other)
        for one, two in zip(group, other, strict=True):
            np.testing.assert_array_equal(one, two)
    box, ball, soft = again.compiled.layout.shapes
    assert isinstance(box, SurfaceShape)
    assert box.triangles.shape == (12, 3)
    assert soft is None
    assert ball == SphereShape(0.1)
    np.testing.assert_array_equal(again.point("soft", "4"), flight.point("soft", "4"))
    np.testing.assert_array_equal(again.momentum().angular, flight.momentum().angular)
    np.testing.assert_array_equal(again.orientation("box").as_matrix(), flight.orientation("box").as_matrix())
    np.testing.assert_array_equal(again.at(0.0103).q, flight.at(0.0103).q)
    assert again.summary() == flight.summary()


def test_modes_are_told_with_their_columns(flight: lf.Result) -> None:
    modes = flight.modes_of("soft")
    np.testing.assert_array_equal(modes.columns, [21, 22, 23])
    np.testing.assert_array_equal(modes.rates, [18, 19, 20])
    names, rates = flight.coordinate_names(), flight.velocity_names()
    assert [names[k] for k in modes.columns] == [rates[k] for k in modes.rates] == [f"soft.mode {k}" for k in (1, 2, 3)]
    assert not len(flight.modes_of("box").columns)


def test_questions_of_the_plane_are_refused_by_name(flight: lf.Result) -> None:
    with pytest.raises(ModelError, match="body: 'box' moves in space and has no one angle"):
        flight.angle("box")
    for ask in (flight.section, flight.stress):
        with pytest.raises(ModelError, match=REFUSED):
            ask("box")
    with pytest.raises(ModelError, match="expected the name of a point or three finite numbers"):
        flight.point("box", (0.1, 0.2))
    with pytest.raises(ModelError, match="is neither a named point nor"):
        flight.point("soft", (5.0, 0.0, 0.0))
    with pytest.raises(ModelError, match="axes: 'ball'"):
        flight.angular_velocity("box", axes="ball")
