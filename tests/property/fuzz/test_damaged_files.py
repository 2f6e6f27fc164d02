"""Every reader of files with files that are cut, changed, of another kind, or claim sizes without end."""

from __future__ import annotations

import io
import random
import re
import zipfile

import numpy as np
import pytest
import scipy.io

import lcpflex as lf
from lcpflex import meshes, solvers
from tests import libs
from tests.property.fuzz.bad_values import write_files
from tests.property.fuzz.face import lcp, matrices, result, small_scene
from tests.property.fuzz.judge import ending_of, limited_memory

SIZE = 10**12  # numbers that an array claims to have
CHANGED = 12  # copies of each file with other bytes


def _mesh(path):
    return lf.Continuum(path, 7800.0, 2e11, 0.3)


def _mass(path):
    scipy.io.mmwrite(path, matrices()["mass"])


def _stiffness(path):
    written = path.with_name("stiffness.mtx")
    scipy.io.mmwrite(written, matrices()["stiffness"])
    return written


def _matrix(path):
    return lf.matrices_from_files(path, _stiffness(path), matrices()["coordinates"])


def _coordinates(path):
    _mass(path.with_name("mass.mtx"))
    return lf.matrices_from_files(path.with_name("mass.mtx"), _stiffness(path), path)


def _saved_mesh(path):
    mesh = meshes.rectangle(0.4, 0.1, 4, 2, order=1)
    cells = {"quad": mesh.t.T}
    places = np.column_stack([mesh.p.T, np.zeros(mesh.p.shape[1])])
    libs.meshio.write_points_cells(path, places, cells, file_format={".vtk": "vtk", ".msh": "gmsh"}.get(path.suffix))


def _solid(path):
    return lf.Solid(path, 7800.0, 2e11, 0.3).finite_elements()


def _saved_solid(path):
    mesh = libs.skfem.MeshTet2.from_mesh(libs.skfem.MeshTet1().refined())
    known = {"tetra10": mesh.dofs.element_dofs.T, "triangle": mesh.facets[:, mesh.boundary_facets()].T}
    cells = known if path.suffix == ".msh" else {"tetra10": known["tetra10"]}
    libs.meshio.write_points_cells(path, mesh.doflocs.T, cells, file_format={".msh": "gmsh22"}.get(path.suffix))


def _mesh_of_fluent(path):
    mesh = meshes.rectangle(0.4, 0.1, 4, 2, order=1)
    libs.meshio.write_points_cells(path, mesh.p.T, {"quad": mesh.t.T}, file_format="ansys")


def _checkpoint(path):
    lf.simulate(small_scene(), 0.01, lf.MoreauJean(step=1e-3), progress=False, checkpoint=path)


def _text(text):
    return lambda path: path.write_text(text, encoding="utf-8")


LCP = "2\n0\n2 2\n2 2\n2 1 1 2\n-1 -1\n"
CONTACTS = "2\n1\n0 2 2\n2 2\n1 0 0 1\n-1 0\n0.5\n"
# What reads a file, the argument by which messages name it, its ending, and what writes a sound one.
READERS = {
    "Result.load": (lf.Result.load, "path", ".npz", lambda path: result().save(path)),
    "Result.load, HDF5": (lf.Result.load, "path", ".h5", lambda path: result().save(path)),
    "resume": (lambda path: lf.resume(path, progress=False), "path", ".npz", _checkpoint),
    "load_problems": (solvers.load_problems, "path", ".npz", lambda path: solvers.save_problems(path, [lcp()])),
    "load_text_lcp": (solvers.load_text_lcp, "path", ".txt", _text("2\n2 1\n1 2\n-1 -1\n")),
    "load_siconos": (solvers.load_siconos, "path", ".dat", _text(CONTACTS)),
    "load_siconos_lcp": (solvers.load_siconos_lcp, "path", ".dat", _text(LCP)),
    "load_siconos_contacts": (solvers.load_siconos_contacts, "path", ".dat", _text(CONTACTS)),
    "load_siconos_mlcp": (solvers.load_siconos_mlcp, "path", ".dat", None),
    "load_fclib": (solvers.load_fclib, "path", ".hdf5", None),
    "mesh of Gmsh": (_mesh, "mesh", ".msh", _saved_mesh),
    "mesh of Fluent": (_mesh, "mesh", ".msh", _mesh_of_fluent),
    "mesh of VTK": (_mesh, "mesh", ".vtk", _saved_mesh),
    "mesh of Abaqus": (_mesh, "mesh", ".inp", _saved_mesh),
    "solid of Gmsh": (_solid, "mesh", ".msh", _saved_solid),
    "solid of Abaqus": (_solid, "mesh", ".inp", _saved_solid),
    "matrix, text": (_matrix, "mass", ".mtx", _mass),
    "matrix, numpy": (_matrix, "mass", ".npy", lambda path: np.save(path, matrices()["mass"].toarray())),
    "coordinates": (_coordinates, "coordinates", ".csv", lambda path: np.savetxt(path, matrices()["coordinates"])),
}


def _endless(content):
    """The file with the header of each of its arrays, if it is one of numpy's, telling a size without end."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({SIZE},), }}".ljust(117) + "\n"
    array = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode()
    if not content.startswith(b"PK"):
        return array
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(out, "w") as new:
        for name in old.namelist():
            kept = name in ("format.npy", "structure.npy")
            new.writestr(name, old.read(name) if kept else array)
    return out.getvalue()


def _cut(content):
    """Beginnings of the file: without anything behind the middle of it, they cannot be whole."""
    return {f"first {share} %": content[: len(content) * share // 100] for share in (5, 25, 50)}


def _changed(content, seed):
    """Copies with a few bytes at random; which are changed may not matter."""
    rng = random.Random(seed)
    for k in range(CHANGED):
        damaged = bytearray(content)
        for _ in range(1 + 3 * k):
            damaged[rng.randrange(len(damaged))] = rng.randrange(256)
        yield bytes(damaged)


def _ending(name, path):
    read, argument, _, _ = READERS[name]
    others = ["mesh", "coordinates", "stiffness"] if argument == "mass" else []
    with limited_memory():
        return ending_of(lambda: read(path), argument, others)


def _sound(name, folder):
    """A file that can be read."""
    read, _, ending, write = READERS[name]
    if READERS[name][2] in (".h5", ".hdf5"):
        pytest.importorskip("h5py")
    if write is None:
        if name == "load_siconos_mlcp":
            pytest.skip("no writer, and the form is long: see tests/contract")
        path = solvers.save_fclib(folder / "sound.hdf5", solvers.ContactProblem(np.eye(2), [-1.0, 0.1], [0.3]))
    else:
        path = folder / f"sound{ending}"
        write(path)
    read(path)
    return path


@pytest.mark.parametrize("name", READERS)
def test_what_is_no_such_file_is_refused(name, tmp_path):
    if READERS[name][2] in (".h5", ".hdf5"):
        pytest.importorskip("h5py")
    ending = READERS[name][2]
    for label, path in write_files(tmp_path).items():
        named = path.with_suffix(ending)
        if path.exists():
            path.rename(named)
        end = _ending(name, named)
        assert end.kind == "refused", (label, end)
        assert named.name in end.said, (label, end)


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_damaged_files_are_refused(name, tmp_path):
    sound = _sound(name, tmp_path)
    content = sound.read_bytes()
    path = tmp_path / f"damaged{sound.suffix}"
    for label, part in {**_cut(content), "endless": _endless(content)}.items():
        path.write_bytes(part)
        end = _ending(name, path)
        assert end.kind == "refused", (label, end)
        assert path.name in end.said, (label, end)
    for k, changed in enumerate(_changed(content, seed=7)):
        path.write_bytes(changed)
        assert _ending(name, path).kind in ("refused", "result"), (k, _ending(name, path))


def _headers(content):
    """Where the headers of a zip file begin: of the entries, of its list of them, and of the end."""
    return [found.start() for found in re.finditer(rb"PK(\x01\x02|\x03\x04|\x05\x06)", content)]


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name, reader in READERS.items() if reader[2] == ".npz"])
def test_zip_files_with_damaged_headers_are_refused(name, tmp_path):
    """Versions, methods of compression, encryption and sizes: whatever zipfile raises of them is told."""
    sound = _sound(name, tmp_path)
    content = sound.read_bytes()
    path = tmp_path / "damaged.npz"
    rng = random.Random(11)
    headers = _headers(content)
    for _ in range(300):
        damaged = bytearray(content)
        at = min(rng.choice(headers) + rng.randrange(4, 46), len(content) - 1)
        damaged[at] = rng.randrange(256)
        path.write_bytes(damaged)
        end = _ending(name, path)
        assert end.kind in ("refused", "result"), (at, damaged[at], end)


def test_a_version_of_zip_that_nobody_knows_is_refused(tmp_path):
    path = tmp_path / "result.npz"
    result().save(path)
    content = bytearray(path.read_bytes())
    listed = next(at for at in _headers(content) if content[at + 2] == 1)
    content[listed + 6] = 166  # the version needed to extract, 16.6
    path.write_bytes(content)
    with pytest.raises(lf.ModelError, match=r"path: .*zip file version 16\.6.*expected a result"):
        lf.Result.load(path)


def test_a_mesh_of_fluent_that_is_cut_is_refused(tmp_path):
    """The reader that meshio has for it knows no end."""
    path = tmp_path / "cut.msh"
    path.write_text("(10 (1 1 4 1 2)(\n0 0\n1 0\n")
    end = _ending("mesh of Fluent", path)
    assert end.kind == "refused", end


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_files_of_other_kinds_are_refused(name, tmp_path):
    own = READERS[name]
    others = [other for other in READERS if other != name and READERS[other][3] not in (None, own[3])]
    for other in others:
        if own[1] == READERS[other][1] and own[1] in ("mesh", "mass"):
            continue
        path = tmp_path / f"other{READERS[other][2]}"
        READERS[other][3](path)
        named = path.rename(tmp_path / f"named{own[2]}")
        end = _ending(name, named)
        assert end.kind == "refused" or any({name, other} <= alike for alike in ALIKE), (other, end)


ALIKE = (
    # texts of numbers that are something in each of these forms, and an array that is a matrix, too
    {"load_text_lcp", "load_siconos_lcp", "load_siconos", "load_siconos_contacts"},
    {"Result.load", "Result.load, HDF5"},  # known by their content, whatever their ending
)
