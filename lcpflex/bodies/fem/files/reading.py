"""The mesh in a file, by the format of the file."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from lcpflex.basics.arguments import LARGEST_TEXT
from lcpflex.bodies.fem.files.abaqus import read_abaqus
from lcpflex.bodies.fem.files.found import FoundMesh, Unreadable
from lcpflex.bodies.fem.files.gmsh import is_gmsh, read_gmsh
from lcpflex.bodies.fem.files.others import read_other
from lcpflex.errors import ModelError, path_of, shown

__all__ = ["read_found"]

HEAD = 200  # bytes by which the format of a file is told


def read_found(path: str | os.PathLike[str]) -> FoundMesh:
    """Places, elements and groups in a file of Gmsh, Abaqus, or any format that meshio or meshlane reads.

    Raises
    ------
    ModelError
        For files that are not there, or not what their format says, and places that are not finite.
    """
    name = str(path_of("mesh", path))
    source = f"mesh {name!r}"
    if not Path(name).is_file():
        raise ModelError(f"mesh: {shown(name)} was given, expected the name of a file that is there")
    if Path(name).stat().st_size > LARGEST_TEXT:
        raise ModelError(f"{source}: it is too large, expected a file of at most {LARGEST_TEXT:.0e} bytes")
    try:
        with np.errstate(all="ignore"):  # places that are not finite are refused below, whatever was made of them
            found = _read(name, source)
    except Unreadable as error:
        raise ModelError(f"{source}: cannot read it: {error}") from None
    except OSError as error:
        raise ModelError(f"{source}: {error.strerror or error}, expected a file that can be read") from None
    except MemoryError:
        raise ModelError(f"{source}: there is too little memory for it, expected a smaller mesh") from None
    wrong = ~np.isfinite(found.points).all(axis=1)
    if wrong.any():
        k = int(wrong.argmax())
        raise ModelError(f"{source}: node {k} is at {found.points[k].tolist()}, expected finite places")
    return found


def _read(name: str, source: str) -> FoundMesh:
    with Path(name).open("rb") as file:
        head = file.read(HEAD)
    if name.lower().endswith(".inp") or head.lstrip().startswith(b"*"):
        return read_abaqus(Path(name), source)
    if is_gmsh(head) or (name.lower().endswith(".msh") and not head.startswith(b"(")):  # with one: of Fluent
        return read_gmsh(Path(name).read_bytes(), source)
    return read_other(name, source)
