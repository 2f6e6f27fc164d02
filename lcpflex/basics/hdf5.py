"""HDF5 files through h5py, which is optional: written as a whole or not at all, and read without faith."""

from __future__ import annotations

import io
import math
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.archives import check_hdf5, pad_hdf5
from lcpflex.basics.whole_file import whole_file
from lcpflex.errors import ModelError

__all__ = ["array_of", "create", "h5py_for", "opened", "put_array", "whole_hdf5"]

SMALL = 1024  # bytes: what is smaller is not worth a chunk of its own
CHUNK = 2**20  # bytes
LEVEL = 4  # of deflate: 9 takes three times as long and saves a per cent


def h5py_for(what: str) -> Any:
    """The package h5py.

    Raises
    ------
    ModelError
        Where it is not installed: "``what`` h5py, which is not installed", and how to get it.
    """
    try:
        return libs.h5py
    except ImportError as error:
        raise ModelError(f"{what} h5py, which is not installed: pip install 'lcpflex[hdf5]'") from error


@contextmanager
def opened(what: str, path: Path) -> Iterator[Any]:
    """An open h5py.File to be read, after its claims were compared with its size: see :func:`.check_hdf5`.

    Raises
    ------
    ModelError
        As :func:`h5py_for` does.
    ValueError
        Without the name of the file, for one that would take far more memory than it has bytes.
    """
    with h5py_for(what).File(path, "r") as file:
        check_hdf5(file, path.stat().st_size)
        yield file


@contextmanager
def whole_hdf5(name: str, path: Any, what: str, libver: str = "v110") -> Iterator[Any]:
    """An open h5py.File, which is at ``path`` at the end of the block, all of it or nothing.

    It is made in memory, and written as any other file: where a disk is full, the HDF5 library ends the process (seen
    with h5py 3.16). ``libver`` is that of h5py; headers of HDF5 1.10 and later have check sums.

    Raises
    ------
    ModelError
        As :func:`.whole_file` does, with the argument ``name``; and as :func:`h5py_for`.
    """
    h5py, made = h5py_for(what), io.BytesIO()
    with whole_file(name, path) as part:
        with h5py.File(made, "w", libver=libver, track_order=True) as file:
            yield file
            file.flush()
            pad_hdf5(file, made.getbuffer().nbytes)
        part.write_bytes(made.getbuffer())


def create(group: Any, name: str, shape: tuple[int, ...], dtype: npt.DTypeLike) -> Any:
    """A data set to be filled, compressed where it is not small."""
    row = math.prod(shape[1:]) * np.dtype(dtype).itemsize
    if not shape or shape[0] * row < SMALL:
        return group.create_dataset(name, shape, dtype)
    chunks = (min(shape[0], max(CHUNK // row, 1)), *shape[1:])
    return group.create_dataset(
        name, shape, dtype, chunks=chunks, compression="gzip", compression_opts=LEVEL, shuffle=True
    )


def put_array(group: Any, name: str, values: npt.NDArray[Any]) -> None:
    """Write an array, with a check sum over its type, shape and bytes as attribute ``crc32``."""
    dataset = create(group, name, values.shape, values.dtype)
    dataset[...] = values
    dataset.attrs["crc32"] = np.uint32(_check_sum(values))


def array_of(group: Any, name: str) -> npt.NDArray[Any]:
    """Read what :func:`put_array` wrote to a file of :func:`opened`; KeyError, ValueError or OSError for another."""
    dataset = group[name]
    values = np.asarray(dataset[()])
    if _check_sum(values) != int(dataset.attrs["crc32"]):
        raise ValueError(f"the check sum of {name} is another")
    return values


def _check_sum(values: npt.NDArray[Any]) -> int:
    about = zlib.crc32(f"{values.dtype.str}{values.shape}".encode())
    return zlib.crc32(np.ascontiguousarray(values).data, about)
