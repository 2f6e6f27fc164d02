"""Contact problems in the HDF5 files of FCLIB, read and written.

Acary et al., "A collection of 3D frictional contact problems" (2014). Local problems, u = W r + q, and global ones,
M v = H r + G y + f, G^T v + b = 0, u = H^T v + w, from which the motion of the bodies is eliminated. Matrices are
stored as in CSparse.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.hdf5 import opened, whole_hdf5
from lcpflex.errors import ModelError, path_of
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact.condensation import (
    condensed,
    condensed_sparse,
    contact_problem,
    multiplied_out,
    planar_rows,
)
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.contact.spatial import SpatialContactProblem

__all__ = ["load_fclib", "save_fclib"]

LARGEST = 8000  # rows of a matrix that becomes a dense one
MOST = 1_000_000  # rows of any, and a hundred times as many entries
SHOWN = 120  # characters of a message of HDF5, and of a path
NEEDS = "FCLIB files need"
LOCAL = "/fclib_local with W, vectors/q, vectors/mu, spacedim"
GLOBAL = "/fclib_global with M, H, vectors/f, vectors/w, vectors/mu, spacedim"


def load_fclib(path: str | os.PathLike[str]) -> ContactProblem | SpatialContactProblem:
    """The problem of an FCLIB HDF5 file: in the plane or in space.

    Of a global problem the motion of the bodies, with their joints, is eliminated by a dense factorisation, beyond 8000
    rows by a sparse one. Needs h5py. Raises ModelError without it, for a damaged file, for bodies whose equations are
    singular, for rolling friction, for matrices of more than a million rows, and for global problems with joints of
    more than 8000. The W of a local problem stays sparse.

    path: of the file.
    """
    path = path_of("path", path)
    name = f"path {str(path)[-SHOWN:]!r}"
    expected = LOCAL
    try:
        with opened(NEEDS, path) as file:
            if "fclib_local" in file:
                W, q, mu, dimension = _local(file["fclib_local"])
            elif "fclib_global" in file:
                expected = GLOBAL
                W, q, mu, dimension = _global(file["fclib_global"])
            else:
                form = "rolling friction, which is not read" if "fclib_global_rolling" in file else "no problem"
                raise ModelError(f"holds {form}; expected the group fclib_local or fclib_global")
        return contact_problem(W, q, mu, dimension)
    except ModelError as error:
        raise ModelError(f"{name}: {error}") from error
    except (OSError, KeyError, ValueError, TypeError, IndexError, AttributeError, RuntimeError, OverflowError) as error:
        raise ModelError(f"{name}: {str(error)[:250]}; expected {expected}") from error


def save_fclib(path: str | os.PathLike[str], problem: ContactProblem | SpatialContactProblem) -> Path:
    """Write a local problem to an FCLIB HDF5 file and return its path; read back it has the same numbers.

    Tangents without friction, which a planar problem does not have, are written as rows of zeros. Needs h5py. The file
    appears whole or not at all. Raises ModelError without h5py, for a problem of another kind, and for a path that
    cannot be written.
    """
    if isinstance(problem, ContactProblem):
        (W, q), dimension = planar_rows(problem), 2
    elif isinstance(problem, SpatialContactProblem):
        W, q, dimension = multiplied_out(problem), problem.free, 3
    else:
        kind = type(problem).__name__
        raise ModelError(f"problem is a {kind}: expected a ContactProblem or a SpatialContactProblem")
    target = path_of("path", path)
    with whole_hdf5("path", target, NEEDS, libver="earliest") as file:
        group = file.create_group("fclib_local")
        group["spacedim"] = np.array([dimension], dtype=np.int32)
        _write(group.create_group("W"), W)
        group["vectors/q"], group["vectors/mu"] = q, problem.friction
        group["info/title"] = np.bytes_("contact problem")
        group["info/description"] = np.bytes_("written by lcpflex")
        group["info/math_info"] = np.bytes_(f"{len(problem.friction)} contacts")
    return target


def _local(group: Any) -> tuple[Any, FloatArray, FloatArray, int]:
    """W, q, mu and the dimension."""
    W = _matrix(group, "W")
    return W, _vector(group, "q"), _vector(group, "mu"), _whole(group, "spacedim")


def _global(group: Any) -> tuple[Any, FloatArray, FloatArray, int]:
    """The same of a global problem, its bodies eliminated: by sparse factors beyond LARGEST rows, where W is sparse."""
    M, H = _matrix(group, "M"), _matrix(group, "H")
    f, w, mu = (_vector(group, key) for key in ("f", "w", "mu"))
    n, m = M.shape[0], H.shape[1]
    if M.shape != (n, n) or H.shape != (n, m) or f.shape != (n,) or w.shape != (m,):
        raise ModelError(
            f"M has shape {M.shape}, H {H.shape}, f {f.shape} and w {w.shape}: expected (n, n), (n, m), (n,), (m,)"
        )
    G = b = None
    if "G" in group:
        G, b = _matrix(group, "G"), _vector(group, "b")
        if G.shape != (n, len(b)):
            raise ModelError(f"G has shape {G.shape} and b {b.shape}: expected ({n}, p) and (p,)")
    for key, values in (("M", M.data), ("H", H.data), ("f", f), ("w", w), ("G", getattr(G, "data", None)), ("b", b)):
        if values is not None and not np.isfinite(values).all():
            raise ModelError(f"{key} holds NaN or inf: expected finite numbers")
    dimension = _whole(group, "spacedim")
    if n > LARGEST and G is None:
        return *condensed_sparse(M, H, f, w), mu, dimension
    dense = _dense("M", M), _dense("H", H), f, w, None if G is None else _dense("G", G), b
    return *condensed(*dense), mu, dimension


def _whole(group: Any, key: str) -> int:
    """One whole number, which HDF5 stores as an array."""
    values = np.asarray(group[key]).ravel()
    if values.size != 1 or values.dtype.kind not in "iu":
        raise ModelError(f"{key} is {values[:4]}: expected one whole number")
    return int(values[0])


def _vector(group: Any, key: str) -> FloatArray:
    values = group[f"vectors/{key}"]
    if values.size > MOST:
        raise ModelError(f"vectors/{key} has {values.size} numbers: expected at most {MOST}")
    return np.asarray(values, dtype=float).ravel()


def _dense(name: str, matrix: Any) -> FloatArray:
    """A matrix of at most LARGEST rows as an array."""
    if max(matrix.shape) > LARGEST:
        rows, columns = matrix.shape
        raise ModelError(
            f"{name} has {rows} rows and {columns} columns: expected at most {LARGEST}, as it becomes dense"
        )
    return np.asarray(matrix.toarray())


def _matrix(owner: Any, name: str) -> Any:
    """A CSR array from its CSparse arrays: nz >= 0 triplets (columns in p), -1 compressed columns, -2 rows."""
    group = owner[name]
    m, n, nz = (_whole(group, key) for key in ("m", "n", "nz"))
    if not (0 <= m <= MOST and 0 <= n <= MOST):
        raise ModelError(f"{name} has {m} rows and {n} columns: expected at most {MOST}")
    if any(group[key].size > 100 * MOST for key in ("p", "i", "x")):
        raise ModelError(f"{name} has more than {100 * MOST} entries: expected fewer")
    p, i, x = (np.asarray(group[key]).ravel() for key in ("p", "i", "x"))
    if nz >= 0:
        return libs.sparse.csr_array((x[:nz].astype(float), (i[:nz], p[:nz])), shape=(m, n))
    if nz not in (-1, -2):
        raise ModelError(f"{name}/nz is {nz}: expected >= 0 (triplets), -1 (columns) or -2 (rows)")
    lines, places = (n, m) if nz == -1 else (m, n)
    used = int(p[-1]) if len(p) else -1
    if len(p) != lines + 1 or p[0] != 0 or (np.diff(p) < 0).any() or not used <= min(len(i), len(x)):
        raise ModelError(f"{name}/p is {p[:6]} ...: expected {lines + 1} numbers that rise from 0 to at most {len(x)}")
    if used and not (int(i[:used].min()) >= 0 and int(i[:used].max()) < places):
        raise ModelError(f"{name}/i holds {int(i[:used].max())}: expected places from 0 to {places - 1}")
    kind = libs.sparse.csc_array if nz == -1 else libs.sparse.csr_array
    return libs.sparse.csr_array(kind((x[:used].astype(float), i[:used], p), shape=(m, n)))


def _write(group: Any, W: Any) -> None:
    """A matrix by compressed columns."""
    stored = libs.sparse.csc_array(W)
    sizes = {"nzmax": stored.nnz, "m": W.shape[0], "n": W.shape[1], "nz": -1}
    for key, value in sizes.items():
        group[key] = np.array([value], dtype=np.int32)
    group["p"], group["i"] = stored.indptr.astype(np.int32), stored.indices.astype(np.int32)
    group["x"] = stored.data
