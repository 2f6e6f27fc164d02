"""A measured error in charts and tables."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf


@pytest.fixture(scope="module")
def verified() -> lf.Result:
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(radius=0.05, mass=1.0), name="disc", position=(0.0, 0.1))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(disc.surface(), floor, restitution=0.5, name="floor")
    return lf.simulate(scene, 0.4, lf.MoreauJean(step=5e-3), verify=True)


def test_chart_shades_what_may_be_off(verified: lf.Result) -> None:
    axes = verified.plot().axes
    assert "shaded" in axes[0].get_title(loc="left")
    assert axes[1].collections  # the band of the gap
    without = lf.simulate(_free(), 0.1, lf.MoreauJean(step=5e-3)).plot()
    assert not any(ax.collections for ax in without.axes)


def _free() -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -9.81))
    scene.add(lf.Disc(radius=0.05, mass=1.0))
    return scene


def test_xarray_holds_the_error(verified: lf.Result) -> None:
    pytest.importorskip("xarray")
    error = verified.error
    assert error is not None
    table = verified.to_xarray()
    assert np.array_equal(table.error_place_curve.values, error.place_curve)
    assert table.error_place_curve.attrs["units"] == "m"
    assert table.attrs["error_place"] == error.place
    assert table.error_impulse.values[0] == error.impulse["floor"]
    assert list(table.error_body.values) == ["disc"]


def test_dataframe_holds_the_numbers(verified: lf.Result) -> None:
    pytest.importorskip("pandas")
    assert verified.error is not None
    assert verified.to_dataframe().attrs["error_horizon"] == verified.error.horizon
