"""VTKHDF, the form of files of ParaView: an UnstructuredGrid that moves, written by h5py.

Cells stand in the file once, points and what is known at them of all instants one behind the other; ``Steps`` tells
where those of each instant begin. Several grids in one file (a PartitionedDataSetCollection) are not written: the
reader of VTK 9.7 stays at their first instant, whichever one asks for, unless it was updated once before.

Source: "VTKHDF format specification", version 2.0, docs.vtk.org.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics.hdf5 import create

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Grid", "distinct", "write_grid"]

VERTEX = 1  # type of a cell
VERSION = (2, 0)  # of the format: the first with instants


class Grid(NamedTuple):
    """Points and cells at m instants; the cells are the same at all of them or, without any, each point is a vertex."""

    counts: IntArray  # (m,) points
    cells: tuple[tuple[int, tuple[int, ...]], ...]  # type, by the numbers of VTK, and points of each
    cell_data: dict[str, IntArray]  # of the cells, or the vertices of all instants
    arrays: dict[str, int]  # of points: name and number of columns
    pages: Iterable[dict[str, FloatArray]]  # "Points" (k, 3) and each of the arrays, some instants at a time

    @property
    def numbers(self) -> int:
        """How many it has at points, over all instants."""
        return int(self.counts.sum()) * (3 + sum(self.arrays.values()))


def distinct(times: FloatArray) -> FloatArray:
    """Times that rise: the second of two equal ones, as of an event, is the next larger number."""
    values = times.copy()
    for k in range(1, len(values)):
        if values[k] <= values[k - 1]:
            values[k] = np.nextafter(values[k - 1], np.inf)
    return values


def write_grid(file: Any, grid: Grid, times: FloatArray) -> None:
    """Cells, points, what is known at them, and where those of each instant begin; times (m,) [s] rise."""
    root = file.create_group("VTKHDF", track_order=True)
    root.attrs["Version"] = np.array(VERSION, dtype=np.int64)
    root.attrs["Type"] = np.bytes_("UnstructuredGrid")  # of fixed length
    still = np.zeros(len(times), dtype=np.int64)
    starts = np.concatenate([[0], np.cumsum(grid.counts)[:-1]])
    changing = not grid.cells
    _put(root, _vertices(grid.counts) if changing else _cells(grid))
    _put(root.create_group("CellData", track_order=True), grid.cell_data)
    _write_pages(root, grid)
    steps = root.create_group("Steps", track_order=True)
    steps.attrs["NSteps"] = len(times)
    first = starts if changing else still  # cells are as many as points where they change
    part = np.arange(len(times)) if changing else still
    _put(steps, {"Values": times, "PartOffsets": part, "NumberOfParts": still + 1})
    _put(steps, {"PointOffsets": starts, "CellOffsets": first[:, None], "ConnectivityIdOffsets": first[:, None]})
    _put(steps.create_group("PointDataOffsets"), dict.fromkeys(grid.arrays, starts))
    _put(steps.create_group("CellDataOffsets"), dict.fromkeys(grid.cell_data, first))


def _cells(grid: Grid) -> dict[str, Any]:
    """Of one part, which serves all instants."""
    sizes = [len(own) for _, own in grid.cells]
    return {
        "NumberOfPoints": grid.counts[:1],
        "NumberOfCells": [len(sizes)],
        "NumberOfConnectivityIds": [sum(sizes)],
        "Types": np.array([kind for kind, _ in grid.cells], dtype=np.uint8),
        "Offsets": np.cumsum([0, *sizes]),
        "Connectivity": np.array([k for _, own in grid.cells for k in own], dtype=np.int64),
    }


def _vertices(counts: IntArray) -> dict[str, Any]:
    """A part of each instant, with a vertex at each of its points."""
    ids = [np.arange(count + 1) for count in counts.tolist()]
    return {
        **dict.fromkeys(("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"), counts),
        "Types": np.full(int(counts.sum()), VERTEX, dtype=np.uint8),
        "Offsets": np.concatenate(ids),
        "Connectivity": np.concatenate([own[:-1] for own in ids]),
    }


def _put(group: Any, arrays: dict[str, Any]) -> None:
    for name, values in arrays.items():
        given: NDArray[Any] = np.asarray(values)
        create(group, name, given.shape, given.dtype)[...] = given


def _write_pages(root: Any, grid: Grid) -> None:
    """Points and what is known at them, as it is made."""
    data, total = root.create_group("PointData", track_order=True), int(grid.counts.sum())
    into = {"Points": create(root, "Points", (total, 3), np.float64)}
    for name, columns in grid.arrays.items():
        into[name] = create(data, name, (total, columns) if columns > 1 else (total,), np.float64)
    row = 0
    for page in grid.pages:
        last = row + len(page["Points"])
        for name, dataset in into.items():
            dataset[row:last] = page[name]
        row = last
