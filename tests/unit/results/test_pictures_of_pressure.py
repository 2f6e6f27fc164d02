"""Pressures in pictures, charts and files for ParaView: cells as large as their areas, and no colour without one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.errors import ModelError
from lcpflex.results.result import Result
from lcpflex.results.spatial.pressed_areas import cells_of
from tests import libs
from tests.unit.results.drawn import sliding
from tests.unit.results.test_contact_patch import NOTHING, hertz, history_of

UP = np.array([0.0, 0.0, 1.0])
SIDES = 0.2, 0.1  # of the face that slides [m]


@cache
def pressing(bare: int = 0) -> Result:
    """A box of 2 kg that slides on four corners, all but ``bare`` of which stand for a quarter of its face."""
    result = sliding(0.0)
    points = result.contact_points
    area = np.full(len(points.record), 0.25 * SIDES[0] * SIDES[1])
    area[np.arange(len(area)) % 4 < bare] = 0.0
    return replace(result, contact_points=replace(points, area=area))


def grid(nx: int, ny: int, h: float, turned: Any = None) -> tuple[Any, Any, Any]:
    """Nodes of a rectangle of squares of length h: places, normals, and areas as the hats have them."""
    x, y = np.meshgrid(h * np.arange(nx + 1), h * np.arange(ny + 1), indexing="ij")
    ends = [np.where(np.isin(np.arange(n + 1), (0, n)), 0.5, 1.0) for n in (nx, ny)]
    axes = np.eye(3) if turned is None else turned.as_matrix()
    places = np.column_stack([x.ravel(), y.ravel(), 0.0 * x.ravel()]) @ axes.T
    return places, np.tile(axes[:, 2], (x.size, 1)), h**2 * np.outer(*ends).ravel()


def arrows_of(scene: Any) -> int:
    return sum(isinstance(one, libs.Annotation) and one.arrow_patch is not None for one in scene.texts)


def size_of(cell: Any) -> float:
    return 0.5 * float(np.linalg.norm(np.cross(cell - cell[0], np.roll(cell - cell[0], -1, axis=0)).sum(axis=0)))


@pytest.mark.parametrize("h", [1e-7, 1.0, 1e5])
def test_nodes_of_a_face_have_cells_as_large_as_their_areas(h: float) -> None:
    turned = Rotation.from_rotvec([0.3, -0.7, 0.4])
    places, normals, areas = grid(6, 3, h, turned)
    cells = cells_of(places + h * np.array([30.0, -5.0, 2.0]), normals, areas)
    assert [size_of(cell) for cell in cells] == pytest.approx(areas, rel=1e-9)
    reach = np.ptp((np.concatenate(cells) @ turned.as_matrix())[:, :2], axis=0)
    assert reach == pytest.approx([6.0 * h, 3.0 * h], rel=1e-9)


def test_middles_of_areas_have_cells_that_reach_beyond_them() -> None:
    """A circle of squares: in the middle squares; at its rim what is left of the circle."""
    places, _, areas = hertz(6)
    cells = cells_of(places, np.tile(np.cross([0.6, 0.8, 0.0], [-0.48, 0.36, 0.8]), (len(places), 1)), areas)
    sizes = np.array([size_of(cell) for cell in cells]) / areas
    away = np.linalg.norm(places - places.mean(axis=0), axis=1)
    assert sizes[away < 0.5e-3] == pytest.approx(1.0, rel=1e-9)
    assert sizes.sum() == pytest.approx(len(sizes), rel=0.03)
    assert 0.6 < sizes.min() <= sizes.max() <= 1.3


@pytest.mark.parametrize("count", [1, 2, 5])
def test_few_or_aligned_places_have_cells_of_their_areas(count: int) -> None:
    """A polygon of 24 sides has .99 of the area of its circle, and of cells that meet the search is the same."""
    places = np.outer(np.arange(count), [3.0, 0.0, 0.0])
    cells = cells_of(places, np.tile(UP, (count, 1)), np.full(count, 2.0))
    assert [size_of(cell) for cell in cells] == pytest.approx(np.full(count, 2.0), rel=0.01)


def test_beside_an_open_node_no_cell_grows_into_its_place() -> None:
    places, normals, areas = (np.delete(part, 12, axis=0) for part in grid(4, 4, 1.0))  # without that in the middle
    sizes = np.array([size_of(cell) for cell in cells_of(places, normals, areas)])
    assert sizes.max() <= 1.3 + 1e-9
    assert cells_of(*(part[:0] for part in (places, normals, areas))) == []


def test_two_points_at_one_place_have_the_same_cell() -> None:
    """As of a node that touches on the edge of two facets."""
    first, second = cells_of(np.zeros((2, 3)), np.tile(UP, (2, 1)), np.ones(2))
    np.testing.assert_array_equal(first, second)


def test_of_a_curved_patch_cells_lie_across_their_own_normals() -> None:
    angle = np.linspace(0.0, 2.0, 12)
    normals = np.column_stack([np.cos(angle), 0.0 * angle, np.sin(angle)])
    for cell, normal in zip(cells_of(0.1 * normals, normals, np.full(12, 1e-4)), normals, strict=True):
        assert np.abs((cell - 0.1 * normal) @ normal).max() < 1e-15
        assert size_of(cell) <= 1.3e-4


def test_a_chart_has_the_patch_in_its_plane_and_the_scale_of_its_pressures() -> None:
    figure = history_of([NOTHING, hertz(6)]).plot_pressure(1e-3)
    patch, scale = figure.axes
    assert patch.get_title(loc="left").startswith("hit, t = 0.001 s: 1.61")
    assert scale.get_ylabel() == "pressure [GPa]"
    cells = patch.collections[0]
    assert cells.get_clim() == pytest.approx((0.0, 1.2 * np.sqrt(1.0 - 2.0 / 12.0**2)))  # in a cell beside the middle
    assert patch.get_xlabel() == "x from the centre of the force [mm]"  # whose normals are z
    assert patch.get_ylabel() == "y [mm]"


def test_a_chart_is_drawn_into_given_axes_and_says_where_nothing_touches() -> None:
    axes = libs.Figure().subplots()
    assert history_of([NOTHING, hertz(4)]).plot_pressure(0.0, axes) is axes.get_figure()
    assert axes.get_title(loc="left") == "hit, t = 0 s: no contact"
    with pytest.raises(ModelError, match="axes"):
        history_of([hertz(4)]).plot_pressure(0.0, 3)  # type: ignore[arg-type]
    places, forces, areas = hertz(4)
    with pytest.raises(ModelError, match="on no area"):
        history_of([(places, forces, 0.0 * areas)]).plot_pressure(0.0)


def test_a_picture_has_areas_in_colours_in_the_place_of_their_arrows() -> None:
    result = pressing()
    figure = result.draw(result.times[-1], pressure=True)
    scene, scale = figure.axes
    cells = scene.collections[-1]
    pressure = result.contact_points.at(len(result.times) - 1).normal_force / (0.25 * SIDES[0] * SIDES[1])
    assert scale.get_ylabel() == "pressure [kPa]"
    assert sorted(np.asarray(cells.get_array())) == pytest.approx(sorted(pressure / 1e3))
    assert arrows_of(scene) == 0


def test_where_nothing_presses_there_is_no_scale() -> None:
    result = pressing()
    still = replace(result, contact_points=replace(result.contact_points, force=0.0 * result.contact_points.force))
    assert len(result.draw(result.times[-1], pressure=True).axes) == 2
    assert len(still.draw(result.times[-1], pressure=True).axes) == 1
    places, forces, areas = hertz(4)
    assert len(history_of([(places, 0.0 * forces, areas)]).plot_pressure(0.0).axes) == 1


def test_forces_on_no_area_stay_arrows() -> None:
    result = pressing(bare=1)
    scene = result.draw(result.times[-1], pressure=True).axes[0]
    assert len(scene.collections[-1].get_paths()) == 3
    assert arrows_of(scene) == 2  # one force, and that of the key


def test_pressures_are_refused_where_there_are_none(swing: Result) -> None:
    bare = sliding(0.0)
    with pytest.raises(ModelError, match="pressure: True was given, expected False where no force of the run"):
        bare.draw(0.0, pressure=True)
    with pytest.raises(ModelError, match=r"^pressure: "):
        bare.draw(0.0, pressure="yes")  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="pressure: it is for pictures of a SpatialScene"):
        swing.draw(0.0, pressure=True)


def test_a_film_has_one_scale_of_colours(tmp_path: Path) -> None:
    path = pressing().animate(tmp_path / "film.gif", fps=4.0, slowdown=50.0, pressure=True)
    assert path.stat().st_size > 0


@pytest.mark.skipif(find_spec("h5py") is None, reason="needs h5py")
@pytest.mark.parametrize("bare", [0, 1])
def test_paraview_has_pressures_of_touching_points(tmp_path: Path, bare: int) -> None:
    result = pressing(bare)
    points = result.contact_points
    result.to_vtkhdf(tmp_path / "run.vtkhdf")
    with libs.h5py.File(tmp_path / "run_contacts.vtkhdf") as file:
        data = file["VTKHDF/PointData"]
        area, pressure = data["area"][...], data["pressure"][...]
    np.testing.assert_array_equal(area, points.area)
    on = points.area > 0.0
    np.testing.assert_allclose(pressure[on], points.normal_force[on] / points.area[on])
    assert np.isnan(pressure[~on]).all()


@pytest.mark.skipif(find_spec("h5py") is None, reason="needs h5py")
def test_paraview_has_none_where_no_force_acts_on_an_area(tmp_path: Path) -> None:
    sliding(0.0).to_vtkhdf(tmp_path / "run.vtkhdf")
    with libs.h5py.File(tmp_path / "run_contacts.vtkhdf") as file:
        assert not {"area", "pressure"} & set(file["VTKHDF/PointData"])


def test_areas_are_kept_in_files(tmp_path: Path) -> None:
    result = pressing(bare=1)
    loaded = lf.Result.load(result.save(tmp_path / "run.npz"))
    np.testing.assert_array_equal(loaded.contact_points.area, result.contact_points.area)
