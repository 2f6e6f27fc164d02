"""Files for ParaView, read back by VTK's own reader where it is installed, and by h5py."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import meshes
from lcpflex.errors import ModelError
from lcpflex.results.result import Result
from lcpflex.results.shapes_of_scenes import LINE, POLYGON, VERTEX, shapes_of
from lcpflex.results.vtkhdf import distinct
from tests import libs
from tests.scenes import disc_on_floor

pytestmark = pytest.mark.skipif(find_spec("h5py") is None, reason="needs h5py")

STEEL = {"density": 7800.0, "youngs_modulus": 2e11}


@pytest.fixture(scope="module")
def scene() -> Result:
    """A plate, a beam and a bar that bend, a disc and a box that do not; all of it falls, and some of it lands."""
    scene = lf.Scene()
    plate = lf.Continuum(meshes.rectangle(0.4, 0.1, 4, 2, order=2), 7800.0, 2e11, 0.3, thickness=0.01)
    beam = lf.Beam(length=0.7, width=0.03, thickness=0.02, elements=8, **STEEL)
    bar = lf.Bar(length=0.5, area=1e-4, height=0.02, elements=6, **STEEL)
    placed = [
        scene.add(plate.reduce(modes=3), name="plate", position=(-0.6, 0.001), angle=0.02),
        scene.add(beam.reduce(modes=2), name="beam", position=(0.0, 0.2), angle=0.3),
        scene.add(bar.reduce(modes=2), name="bar", position=(1.0, 0.3), angle=1.2),
        scene.add(
            lf.Disc(0.05, mass=1.0), name="disc", position=(-0.8, 0.05), velocity=(0.4, 0.0), angular_velocity=-8.0
        ),
        scene.add(lf.Box(0.2, 0.1, mass=1.0), name="box", position=(0.3, 0.7), angular_velocity=3.0),
    ]
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for body in (placed[0], placed[3]):
        scene.contact(body.surface(), floor, friction=0.3, name=f"{body.name} on floor")
    scene.contact(placed[4].surface(), scene.ground.chain([(2.0, 0.0), (2.1, 0.5), (2.2, 0.0)]), name="never")
    return lf.simulate(scene, 0.03, lf.MoreauJean(step=2e-4), record=2e-3, progress=False)


@pytest.fixture(scope="module")
def written(scene: Result, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scene.to_vtkhdf(tmp_path_factory.mktemp("paraview") / "run.vtkhdf")


class Reader:
    """VTK's reader of one file."""

    def __init__(self, path: Path) -> None:
        io = pytest.importorskip("vtkmodules.vtkIOHDF", reason="needs vtk: pip install vtk")
        self._numpy = pytest.importorskip("vtkmodules.util.numpy_support").vtk_to_numpy
        self._keys = pytest.importorskip("vtkmodules.vtkCommonExecutionModel").vtkStreamingDemandDrivenPipeline
        self._reader = io.vtkHDFReader()
        assert self._reader.CanReadFile(str(path))
        self._reader.SetFileName(str(path))
        self._reader.UpdateInformation()

    @property
    def times(self) -> Any:
        told, key = self._reader.GetOutputInformation(0), self._keys.TIME_STEPS()
        return np.array([told.Get(key, k) for k in range(told.Length(key))])

    def at(self, t: float) -> tuple[Any, dict[str, Any], dict[str, Any], list[tuple[int, list[int]]]]:
        """Points, arrays of points and of cells, and the cells."""
        self._reader.UpdateTimeStep(t)
        grid = self._reader.GetOutputDataObject(0)
        points = self._numpy(grid.GetPoints().GetData()) if grid.GetNumberOfPoints() else np.zeros((0, 3))
        arrays = [
            {data.GetArrayName(k): self._numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())}
            for data in (grid.GetPointData(), grid.GetCellData())
        ]
        cells = (grid.GetCell(k) for k in range(grid.GetNumberOfCells()))  # one object, which each overwrites
        told = [(one.GetCellType(), [one.GetPointId(i) for i in range(one.GetNumberOfPoints())]) for one in cells]
        return points, *arrays, told


def rows_of(result: Result, name: str) -> tuple[slice, Any]:
    """Points of a body in the file, if they are all of a shape, and the shape."""
    b, first = result.compiled.layout.bodies.index(name), 0
    for shape in shapes_of(result, result.compiled):
        if (shape.owner == b).all():
            return slice(first, first + len(shape.owner)), shape
        first += len(shape.owner)
    raise AssertionError(name)


def test_vtk_reads_every_instant_with_points_where_they_are(scene: Result, written: Path) -> None:
    reader = Reader(written)
    np.testing.assert_array_equal(reader.times, scene.times)
    told = [reader.at(t) for t in scene.times]
    for name, outer in (("plate", (0.0, 0.1, 1)), ("beam", (-0.01, 0.01, 1)), ("bar", (0.0, 0.0, 1))):
        rows, shape = rows_of(scene, name)
        chosen = np.flatnonzero(np.isin(shape.places[:, outer[2]].round(12), outer[:2]))[::3]
        known = [tuple(shape.places[k]) for k in chosen]
        known, chosen = (
            (known, chosen) if name != "bar" else ([(0.0, 0.0)], [int(np.abs(shape.places).sum(1).argmin())])
        )
        paths = np.stack([scene.point(name, place) for place in known])
        speeds = np.stack([scene.velocity(name, place) for place in known])
        assert len(paths) > 0
        for k, (points, arrays, _, _) in enumerate(told):
            np.testing.assert_allclose(points[rows][chosen, :2], paths[:, k], rtol=0, atol=1e-14)
            np.testing.assert_allclose(arrays["velocity"][rows][chosen, :2], speeds[:, k], rtol=1e-12, atol=1e-12)
            moved = paths[:, k] - paths[:, 0]
            np.testing.assert_allclose(arrays["displacement"][rows][chosen, :2], moved, rtol=0, atol=1e-14)
            assert not points[:, 2].any()


def test_vtk_reads_rigid_bodies_and_the_ground(scene: Result, written: Path) -> None:
    reader, names = Reader(written), scene.compiled.layout.bodies
    for t, center, angle in zip(scene.times, scene.point("disc", "center"), scene.angle("disc"), strict=True):
        points, arrays, of_cells, cells = reader.at(t)
        own = [cell for cell, body in zip(cells, of_cells["body"], strict=True) if body == names.index("disc")]
        ((_, rim),) = (cell for cell in own if cell[0] == POLYGON)
        np.testing.assert_allclose(np.hypot(*(points[rim, :2] - center).T), 0.05, rtol=1e-12)
        ((_, spoke),) = (cell for cell in own if cell[0] == LINE)
        tip = center + 0.05 * np.array([np.cos(angle), np.sin(angle)])
        np.testing.assert_allclose(points[spoke, :2], [center, tip], rtol=0, atol=1e-14)
        ground = [ids for (_, ids), body in zip(cells, of_cells["body"], strict=True) if body < 0]
        assert len(ground) == 3  # the floor, and two sides of the chain
        assert not any(arrays["displacement"][ids].any() for ids in ground)
        assert any(np.allclose(points[ids, :2], [[2.0, 0.0], [2.1, 0.5]]) for ids in ground)
        assert any(not points[ids, 1].any() and np.ptp(points[ids, 0]) > 1.5 for ids in ground)


def test_vtk_reads_stresses(scene: Result, written: Path) -> None:
    reader = Reader(written)
    found = {name: scene.stress(name).all() for name in ("plate", "beam", "bar")}
    for k, t in enumerate(scene.times):
        _, arrays, _, _ = reader.at(t)
        for name, stress in found.items():
            rows, shape = rows_of(scene, name)
            np.testing.assert_array_equal(arrays["von Mises stress"][rows], stress.von_mises[k, shape.stress_at])
            np.testing.assert_array_equal(arrays["stress"][rows][:, 0], stress.xx[k, shape.stress_at])
            np.testing.assert_array_equal(arrays["stress"][rows][:, 3], stress.xy[k, shape.stress_at])
        assert np.isnan(arrays["von Mises stress"]).sum() == len(arrays["stress"]) - sum(
            len(rows_of(scene, name)[1].owner) for name in found
        )
    assert np.nanmax(arrays["von Mises stress"]) > 0.0


def test_vtk_reads_contact_points_as_many_as_there_are(scene: Result, written: Path) -> None:
    reader, seen = Reader(written.with_name("run_contacts.vtkhdf")), set()
    np.testing.assert_array_equal(reader.times, scene.times)
    for k, t in enumerate(scene.times):
        points, arrays, of_cells, cells = reader.at(t)
        touching = scene.contact_points.at(k)
        assert cells == [(VERTEX, [i]) for i in range(len(touching.record))]
        seen.add(len(cells))
        np.testing.assert_array_equal(points[:, :2], touching.place)
        if not cells:
            continue
        np.testing.assert_array_equal(of_cells["contact"], touching.contact)
        np.testing.assert_array_equal(arrays["state"], touching.state)
        # on the bodies, above the floor: upwards, and against the slip where the disc slides
        np.testing.assert_array_equal(arrays["force"][:, 1], touching.force[:, 0])
        np.testing.assert_array_equal(arrays["force"][:, 0], touching.force[:, 1])
    assert len(seen) > 1


def test_middle_cells_of_a_mesh_of_second_order(scene: Result, written: Path) -> None:
    """Their nodes amid edges are amid their ends, in the order that VTK has."""
    points, _, of_cells, cells = Reader(written).at(scene.times[-1])
    own = [ids for (kind, ids), body in zip(cells, of_cells["body"], strict=True) if body == 0 and kind in (22, 28)]
    assert len(own) == len(scene.compiled.recovery[0].cells)
    corners = 3 if len(own[0]) == 6 else 4
    for ids in own:
        for i in range(corners):
            amid = (points[ids[i]] + points[ids[(i + 1) % corners]]) / 2.0
            np.testing.assert_allclose(points[ids[corners + i]], amid, atol=1e-6)


def test_cells_stand_in_the_file_once(scene: Result, written: Path) -> None:
    with libs.h5py.File(written) as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"UnstructuredGrid"
        n = int(root["NumberOfPoints"][0])
        assert root["Points"].shape == (n * len(scene.times), 3)
        assert root["Offsets"].shape == (int(root["NumberOfCells"][0]) + 1,)
        assert root["CellData/body"].shape == tuple(root["NumberOfCells"])
        np.testing.assert_array_equal(root["Steps/PointOffsets"], n * np.arange(len(scene.times)))
        assert file["lcpflex"].attrs["bodies"].split("\n") == list(scene.compiled.layout.bodies)
        assert file["lcpflex"].attrs["stepper"] == scene.stepper


def test_fewer_instants_and_no_stress(scene: Result, tmp_path: Path) -> None:
    path = scene.to_vtkhdf(tmp_path / "few.vtkhdf", stress=False, every=4)
    with libs.h5py.File(path) as file, libs.h5py.File(path.with_name("few_contacts.vtkhdf")) as touching:
        np.testing.assert_array_equal(file["VTKHDF/Steps/Values"], scene.times[::4])
        assert set(file["VTKHDF/PointData"]) == {"displacement", "velocity", "deflection"}
        counts = [len(scene.contact_points.at(k).record) for k in range(0, len(scene.times), 4)]
        assert list(touching["VTKHDF/NumberOfPoints"]) == counts


def test_both_instants_of_an_event_are_told(tmp_path: Path) -> None:
    result = lf.simulate(disc_on_floor(0.15, restitution=0.5), 0.15, lf.EventDriven(), record=0.01, progress=False)
    assert (np.diff(result.times) == 0.0).any()
    path = result.to_vtkhdf(tmp_path / "events.vtkhdf")
    reader = Reader(path)
    assert (np.diff(reader.times) > 0.0).all()
    np.testing.assert_allclose(reader.times, result.times, rtol=1e-15)
    rows = [reader.at(t)[1]["velocity"] for t in reader.times]
    k = int(np.flatnonzero(np.diff(result.times) == 0.0)[0])
    assert rows[k][0, 1] == pytest.approx(result.u[k, 1], rel=1e-12)
    assert rows[k + 1][0, 1] == pytest.approx(-0.5 * result.u[k, 1], rel=1e-12)


def test_times_that_are_equal_thrice_rise() -> None:
    rising = distinct(np.array([0.0, 1.0, 1.0, 1.0, 2.0]))
    assert (np.diff(rising) > 0.0).all()
    assert rising == pytest.approx([0.0, 1.0, 1.0, 1.0, 2.0], rel=1e-15)


def test_bodies_without_an_outline_are_lines_or_a_point(tmp_path: Path) -> None:
    scene = lf.Scene()
    rod = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), name="rod", position=(0.0, 1.0))
    scene.add(lf.RigidBody(mass=1.0, inertia=0.1), name="mass", position=(2.0, 1.0))
    scene.join(lf.Revolute(rod.at(0.5, 0.0), scene.ground.at(0.5, 1.0)))
    scene.join(lf.Revolute(rod.at(-0.5, 0.0), scene.ground.at(-0.5, 1.0)))
    result = lf.simulate(scene, 2e-3, lf.MoreauJean(step=1e-3), progress=False)
    (shape,) = shapes_of(result, result.compiled)
    told = {(kind, *(tuple(shape.places[k]) for k in ids)) for kind, ids in shape.cells}
    assert (VERTEX, (0.0, 0.0)) in told
    assert {place for kind, *places in told if kind == LINE for place in places} >= {(0.5, 0.0), (-0.5, 0.0)}
    path = result.to_vtkhdf(tmp_path / "rod.vtkhdf")
    assert [one.name for one in tmp_path.iterdir()] == [path.name]  # there are no contacts


def test_what_is_refused(scene: Result, bounce: Result, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"a system of the user's own has no geometry"):
        bounce.to_vtkhdf(tmp_path / "run.vtkhdf")
    with pytest.raises(ModelError, match=r"path: .*run\.vtu.*expected the ending \.vtkhdf"):
        scene.to_vtkhdf(tmp_path / "run.vtu")
    with pytest.raises(ModelError, match="every: 0 was given"):
        scene.to_vtkhdf(tmp_path / "run.vtkhdf", every=0)
    m = 300_000
    long = replace(
        scene, **{
            name: np.broadcast_to(getattr(scene, name)[:1], (m, *getattr(scene, name).shape[1:]))
            for name in ("times", "q", "u", "force", "impulse", "state", "gap", "residual", "penetration",
                         "joint_drift", "size")
        },
        energies=type(scene.energies)(*np.zeros((8, m))),
    )  # fmt: skip
    with pytest.raises(ModelError, match=r"300000 instants would take .* GiB, expected at most 4: take fewer"):
        long.to_vtkhdf(tmp_path / "run.vtkhdf")
    assert not list(tmp_path.iterdir())
