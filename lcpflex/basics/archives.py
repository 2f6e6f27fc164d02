"""Arrays in files of numpy and HDF5, whose claims are compared with what the files hold before anything is unpacked."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Mapping
from typing import IO, Any

import numpy as np

__all__ = ["PADDING", "check_hdf5", "load_arrays", "pad_hdf5", "save_arrays"]

FREE = 2**28  # bytes that any file may unpack to: 268 MB
RATIO = 200  # beyond them, how much larger than the file they may be; results of runs have 2 to 30
SMALL = 1024  # bytes beyond those that deflate can make of what is stored of a data set
DENSEST = 1100  # bytes that deflate can make of one
PADDING = "padding"  # an entry of nothing, with which results of long rests and other such arrays are as large as that
ZIP = (b"PK\x03\x04", b"PK\x05\x06")  # how an archive begins, the second one if it is empty
HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def save_arrays(stream: IO[bytes], arrays: Mapping[str, Any]) -> None:
    """Write arrays by name as a compressed npz file, padded where :func:`load_arrays` would refuse it."""
    unpacked = 0
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            values = np.asanyarray(array)
            unpacked += values.nbytes
            with archive.open(f"{name}.npy", "w", force_zip64=True) as part:
                np.lib.format.write_array(part, values, allow_pickle=False)
        if missing := _missing(unpacked, stream.tell()):
            archive.writestr(PADDING, bytes(missing), zipfile.ZIP_STORED)


def _missing(unpacked: int, size: int) -> int:
    """By how many bytes a file of ``size`` bytes is too small for the ``unpacked`` ones that it would take."""
    return 0 if unpacked <= max(FREE, RATIO * size) else unpacked // (RATIO - 1) - size + SMALL


def load_arrays(stream: IO[bytes]) -> Any:
    """What numpy reads from an open file .npz or .npy, nothing of it pickled, after its claims were looked at.

    Raises ValueError, without the name of the file, where it would take far more memory than it has bytes, and where it
    says that an array is larger than what is there of it; and what zipfile raises.

    Returns an array, or an open archive (``numpy.lib.npyio.NpzFile``).
    """
    size = stream.seek(0, 2)
    stream.seek(0)
    start = stream.read(4)
    stream.seek(0)
    if start in ZIP:
        _check_archive(stream, size)
    else:
        _check_header("the array", stream, size)
    stream.seek(0)
    return np.load(stream, allow_pickle=False)


def _check_archive(stream: IO[bytes], size: int) -> None:
    with zipfile.ZipFile(stream) as archive:
        entries = archive.infolist()
        _refuse_bloated(sum(entry.file_size for entry in entries), size)
        for entry in entries:
            if entry.filename.endswith(".npy"):
                with archive.open(entry) as part:
                    _check_header(entry.filename.removesuffix(".npy")[:60], part, entry.file_size)


def _check_header(name: str, part: IO[bytes], size: int) -> None:
    """Raise ValueError unless ``size`` bytes, the header among them, hold the array that the header tells of."""
    version = np.lib.format.read_magic(part)
    if version not in HEADERS:
        raise ValueError(f"{name} is stored in version {version[0]}.{version[1]} of npy, which is not read")
    shape, _, kind = HEADERS[version](part)
    held, claimed = size - part.tell(), kind.itemsize * math.prod(shape)
    if any(n < 0 for n in shape) or (claimed > held and not kind.hasobject):
        raise ValueError(f"{name} claims the shape {str(shape)[:60]}, {claimed:.3g} bytes, and has {held}")


def check_hdf5(file: Any, size: int) -> None:
    """Raise ValueError for an open HDF5 file of ``size`` bytes that would take far more, or claims more than it has."""
    _refuse_bloated(_unpacked(file), size)


def pad_hdf5(file: Any, size: int) -> None:
    """Make an open HDF5 file of ``size`` bytes so large that :func:`check_hdf5` does not refuse it."""
    missing = _missing(_unpacked(file), size)
    if missing:
        file.create_dataset(PADDING, data=np.zeros(missing, dtype=np.uint8))


def _unpacked(file: Any) -> int:
    """Bytes of all data sets; ValueError for one that is larger than what is stored of it can be.

    One of which nothing was ever stored reads as its fill value, and may take as much as any file.
    """
    total = 0

    def look(name: str, found: Any) -> None:
        nonlocal total
        if not hasattr(found, "dtype"):
            return
        claimed, stored = int(found.size or 0) * found.dtype.itemsize, found.id.get_storage_size()
        most = SMALL + DENSEST * stored if stored or found.is_virtual else FREE
        if claimed > most:
            raise ValueError(
                f"{name[-60:]} claims more numbers than the file holds: the shape {str(found.shape)[:60]}, "
                f"{_bytes(claimed)}, of which {_bytes(stored)} are stored; expected at most {_bytes(most)}"
            )
        total += claimed

    file.visititems(look)
    return total


def _refuse_bloated(unpacked: int, size: int) -> None:
    if _missing(unpacked, size):
        raise ValueError(
            f"the file has {_bytes(size)} and would take {_bytes(unpacked)} when it is unpacked, {unpacked / size:.0f} "
            f"times as much; expected at most {_bytes(FREE)}, or {RATIO} times its size"
        )


def _bytes(count: int) -> str:
    return f"{count / 1e6:.3g} MB" if count < 1e9 else f"{count / 1e9:.3g} GB"
