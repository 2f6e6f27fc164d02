"""Joints of space in tables and files: three components of forces and moments, velocities by names of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.result import Result


@pytest.fixture(scope="module")
def result() -> Result:
    """A pendulum on a hinge."""
    scene = lf.SpatialScene()
    bob = scene.add(lf.SpatialRigidBody(2.0, (0.1, 0.2, 0.25)), "bob", position=(0.3, 0.1, 0.0))
    scene.join(lf.Revolute(bob.at(-0.3, -0.1, 0), scene.ground.at(0, 0, 0), axis=(0, 1, 0), name="hinge"))
    return lf.simulate(scene, 0.02, lf.MoreauJean(step=1e-3))


def test_dataframe(result: Result) -> None:
    """Columns of joints and of velocities."""
    pytest.importorskip("pandas")
    table = result.to_dataframe()
    told = result.reaction("hinge")
    for k, axis in enumerate("xyz"):
        assert table[f"hinge.force {axis}"].to_numpy() == pytest.approx(told.force[:, k], nan_ok=True)
        assert table[f"hinge.moment {axis}"].to_numpy() == pytest.approx(told.moment[:, k], nan_ok=True)
    assert table["bob.omega_y"].to_numpy() == pytest.approx(result.u[:, 4])
    assert table.attrs["units"]["hinge.moment z"] == "N m"
    assert table.attrs["units"]["bob.omega_y"] == "rad/s"


def test_xarray(result: Result) -> None:
    """Dimensions of joints and of velocities."""
    pytest.importorskip("xarray")
    data = result.to_xarray()
    assert data["joint_moment"].dims == ("time", "joint", "axis")
    assert data["axis"].values.tolist() == ["x", "y", "z"]
    last = data["joint_moment"].sel(joint="hinge").isel(time=-1)
    assert last.values == pytest.approx(result.reaction("hinge").moment[-1])
    assert data["u"].dims == ("time", "velocity")
    assert data["u"].sel(velocity="bob.v_z").values == pytest.approx(result.u[:, 2])


def test_file(result: Result, tmp_path: Path) -> None:
    """Reactions of a saved result are the same ones, in any axes."""
    saved = result.save(tmp_path / "run")
    again = Result.load(saved)
    for axes in ("world", "bob"):
        before, behind = result.reaction("hinge", axes), again.reaction("hinge", axes)
        assert np.array_equal(before.force, behind.force, equal_nan=True)
        assert np.array_equal(before.moment, behind.moment, equal_nan=True)
        assert np.array_equal(before.angular_impulse, behind.angular_impulse)
