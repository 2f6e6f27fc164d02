"""Results for ParaView: the scene as it moves, with its stresses, and its contact forces, in VTKHDF files.

``run.vtkhdf`` holds the bodies and the ground, at z = 0 where they are planar, as surfaces of triangles in space. At
points, in world axes but for stresses, which are in the axes of the body:

    displacement      (3) r - r at the first instant [m]
    velocity          (3) [m/s]
    deflection        (3) A Phi q, 0 of rigid bodies [m]
    von Mises stress      [Pa], NaN of bodies whose stresses are not known
    stress            (6) XX, YY, ZZ, XY, YZ, XZ [Pa]

and of cells ``body``, an index, -1 the ground. ``run_contacts.vtkhdf``, of a scene with contacts, holds the touching
points of each instant: force (3), on the body of the node side, normal force, tangential force [N], state (0 open,
1 stick, 2 slip, 3 creep), and ``contact``, an index; in space force and friction force (3) are those on the body of the
first surface of the contact, and normal (3) is towards it; where forces act on areas, area [m^2] and pressure [Pa], NaN
of forces that act on none. Names of bodies and contacts in the order of these, and what
the run was, are attributes of the group ``lcpflex`` of both files.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.arguments import flag, whole_number
from lcpflex.basics.hdf5 import whole_hdf5
from lcpflex.errors import ModelError, path_of
from lcpflex.results.shapes_of_scenes import Shape, motion_of, shapes_of
from lcpflex.results.stress_history import Stress, stress_history
from lcpflex.results.tables import facts
from lcpflex.results.vtkhdf import Grid, distinct, write_grid

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator
    from pathlib import Path

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = ["to_vtkhdf"]

ENDING = ".vtkhdf"
AT_ONCE = 64  # instants
LARGEST = 4 * 2**30  # bytes before compression: files are made in memory
VON_MISES = "von Mises stress"


def to_vtkhdf(result: Result, path: str | os.PathLike[str], stress: bool, every: int) -> Path:
    """See :meth:`lcpflex.results.result.Result.to_vtkhdf`."""
    target = path_of("path", path)
    if target.suffix.lower() != ENDING:
        raise ModelError(f"path: {str(target)!r} was given, expected the ending {ENDING}, by which ParaView knows it")
    with_stress, step = flag("stress", stress), whole_number("every", every, 1)
    compiled = result.compiled
    if compiled is None:
        raise ModelError("to_vtkhdf: a system of the user's own has no geometry; expected the result of a Scene")
    if not len(result.times):
        raise ModelError("to_vtkhdf: a result without stored instants was given, expected one with some")
    records = np.arange(0, len(result.times), step)
    grids = {target: _bodies(result, compiled, shapes_of(result, compiled), records, with_stress)}
    if result.contact_names:
        grids[target.with_stem(f"{target.stem}_contacts")] = _contacts(result, records)
    needed = 8 * sum(one.numbers for one in grids.values())
    if needed > LARGEST:
        raise ModelError(
            f"to_vtkhdf: {len(records)} instants would take {needed / 2**30:.3g} GiB, expected at most "
            f"{LARGEST / 2**30:g}: take fewer of them, as with every={2 * step}, or stress=False"
        )
    names = {"bodies": "\n".join(compiled.layout.bodies), "contacts": "\n".join(result.contact_names)}
    for place, grid in grids.items():
        with whole_hdf5("path", place, f"path: {str(place)!r}: a VTKHDF file needs") as file:
            write_grid(file, grid, distinct(result.times[records]))
            file.create_group("lcpflex").attrs.update({**facts(result), **names})
    return target


def _bodies(result: Result, compiled: CompiledScene, shapes: list[Shape], records: IntArray, with_stress: bool) -> Grid:
    """All shapes, one behind the other."""
    first = np.cumsum([0, *(len(shape.owner) for shape in shapes)]).tolist()
    cells = [
        (kind, tuple(start + k for k in ids))
        for start, shape in zip(first, shapes, strict=False)
        for kind, ids in shape.cells
    ]
    body = np.array([shape.owner[ids[0]] for shape in shapes for _, ids in shape.cells], dtype=np.int64)
    arrays = {"displacement": 3, "velocity": 3, "deflection": 3}
    stressed = with_stress and any(shape.stress_at is not None for shape in shapes)
    arrays |= {VON_MISES: 1, "stress": 6} if stressed else {}
    pages = _pages(result, compiled, shapes, records, stressed)
    return Grid(np.full(len(records), first[-1]), tuple(cells), {"body": body}, arrays, pages)


def _pages(
    result: Result, compiled: CompiledScene, shapes: list[Shape], records: IntArray, stressed: bool
) -> Iterator[dict[str, FloatArray]]:
    """Points and arrays, AT_ONCE instants each."""
    start = _moved(result, compiled, shapes, records[:1])["Points"]
    for first in range(0, len(records), AT_ONCE):
        rows = records[first : first + AT_ONCE]
        page = _moved(result, compiled, shapes, rows)
        page["displacement"] = page["Points"] - start
        if stressed:
            tensors = [_stresses(result, compiled, shape, rows) for shape in shapes]
            whole = np.concatenate(tensors, axis=1)
            page |= {"stress": whole[..., 1:], VON_MISES: whole[..., 0]}
        yield {name: values.reshape(-1, *values.shape[2:]) for name, values in page.items()}


def _moved(result: Result, compiled: CompiledScene, shapes: list[Shape], rows: IntArray) -> dict[str, FloatArray]:
    """(instants, points, 3) of all shapes."""
    each = [motion_of(compiled.model, shape, result.q[rows], result.u[rows]) for shape in shapes]
    names = {"Points": "place", "velocity": "velocity", "deflection": "deflection"}
    return {name: _solid(np.concatenate([getattr(one, part) for one in each], axis=1)) for name, part in names.items()}


def _stresses(result: Result, compiled: CompiledScene, shape: Shape, rows: IntArray) -> FloatArray:
    """(instants, points, 7) von Mises stress, XX, YY, ZZ, XY, YZ and XZ; NaN where they are not known."""
    if shape.stress_at is None:
        return np.full((len(rows), len(shape.owner), 7), np.nan)
    try:
        history = stress_history(result, compiled.layout.bodies[int(shape.owner[0])], True)
        found = Stress(result.times[rows], history.places, *history._recovery.at(rows))
    except ModelError as error:
        raise ModelError(f"{error}; to_vtkhdf(..., stress=False) leaves stresses out") from error
    parts = found.von_mises, found.xx, found.yy, found.zz, found.xy, found.yz, found.zx
    return np.stack(parts, axis=-1)[:, shape.stress_at]


def _contacts(result: Result, records: IntArray) -> Grid:
    """Touching points as vertices, as many as there are at each instant."""
    points = result.contact_points
    chosen = np.isin(points.record, records)
    counts = np.bincount(points.record[chosen], minlength=len(result.times))[records]
    force = points.force[chosen]
    page = {
        "Points": _solid(points.place[chosen]),
        "force": _solid(points.vector[chosen]),
        "normal force": force[:, 0],
    }
    if points.place.shape[1] == 3:
        page |= {"friction force": force[:, 1:], "normal": points.normal[chosen]}
        if (points.area > 0.0).any():
            area = points.area[chosen]
            bare = np.full(len(area), np.nan)  # a force on no area is no pressure
            page |= {"area": area, "pressure": np.divide(force[:, 0], area, out=bare, where=area > 0.0)}
    else:
        page["tangential force"] = force[:, 1]
    page["state"] = points.state[chosen].astype(np.float64)
    arrays = {name: 3 if values.ndim == 2 else 1 for name, values in page.items() if name != "Points"}
    return Grid(counts, (), {"contact": points.contact[chosen]}, arrays, [page])


def _solid(vectors: FloatArray) -> FloatArray:
    """(..., 3) of vectors (..., 2) in the plane z = 0."""
    return np.concatenate([vectors, np.zeros((*vectors.shape[:-1], 3 - vectors.shape[-1]))], axis=-1)
