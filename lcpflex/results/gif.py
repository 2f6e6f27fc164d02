"""GIF films of frames that are mostly the same: one palette for all, and of each frame what has changed."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import IO, TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs

if TYPE_CHECKING:
    from lcpflex.jit.kernel import IntArray

__all__ = ["Gif", "Part", "Pixels", "extent", "palette_of"]

Pixels = npt.NDArray[np.uint32]  # (rows, columns), the bytes of each pixel red, green, blue, alpha
Part = tuple[slice, slice]  # rows and columns of pixels

_UNCHANGED = 255  # the index of the palette that lets the frame before be seen
_UNKNOWN = -1  # a colour whose nearest one in the palette was not looked for yet
_COMMON = 24  # colours of what stands still that are kept to the bit
_SHADES = 4  # of a named colour, towards white
_BITS = 5  # of each colour of a frame, by which its place in the palette is found


def palette_of(still: Pixels, frames: Sequence[Pixels], named: Sequence[str]) -> npt.NDArray[np.uint8]:
    """(255, 3) the commonest colours of what stands still, those ``named``, which may be rare, and those of frames."""
    colours, counts = np.unique(still[::2, ::2], return_counts=True)
    common = _bytes_of(colours[np.argsort(-counts, kind="stable")[:_COMMON]])[:, :3]
    shares = np.arange(_SHADES)[:, None] / _SHADES
    inks = [np.round(255.0 * (shares + (1.0 - shares) * np.array(libs.to_rgb(name)))) for name in named]
    kept = np.concatenate([common, *inks])
    seen = _bytes_of(np.concatenate([frame[::2, ::2] for frame in frames]))[..., :3].copy()
    found = libs.image.fromarray(seen).quantize(_UNCHANGED - len(kept), libs.image.Quantize.FASTOCTREE)
    others = np.array(found.getpalette()).reshape(-1, 3)
    return np.resize(np.concatenate([kept, others]), (_UNCHANGED, 3)).astype(np.uint8)


class Gif:
    """A film that is written frame by frame.

    Parameters
    ----------
    file
        Open for bytes.
    still
        (rows, columns) what of all frames does not move.
    palette
        Colours for all frames, of :func:`palette_of`.
    seconds
        How long a frame is shown, in hundredths at best.
    """

    def __init__(self, file: IO[bytes], still: Pixels, palette: npt.NDArray[np.uint8], seconds: float) -> None:
        self._file, self._still, self._palette = file, still, palette.astype(np.int64)
        self._duration = round(1000.0 * seconds)  # [ms]
        self._nearest = np.full(1 << 3 * _BITS, _UNKNOWN, np.int16)
        self._ground = self._indices(still)
        self._shown = np.full(still.shape, _UNCHANGED, np.uint8)  # nothing: the first frame is whole
        self._moved = (slice(0, still.shape[0]), slice(0, still.shape[1]))  # where the last frame was not still
        rows, columns = still.shape
        file.write(b"GIF89a" + struct.pack("<HHBBB", columns, rows, 0xF7, 0, 0))  # 256 colours for all frames
        file.write(palette.tobytes() + bytes(3))
        file.write(b"!\xff\x0bNETSCAPE2.0\x03\x01" + struct.pack("<HB", 0, 0))  # for ever

    def add(self, frame: Pixels) -> None:
        """One frame: the smallest rectangle that holds what moves now and what has moved before."""
        moving = frame != self._still
        moved = extent(moving)
        part = _union(moved, self._moved)
        self._moved = moved
        indices = self._ground[part].copy()
        chosen = moving[part]
        indices[chosen] = self._indices(frame[part][chosen])
        shown = self._shown[part]
        new = np.where(indices == shown, np.uint8(_UNCHANGED), indices)
        self._shown[part] = indices
        told: dict[str, Any] = {"duration": self._duration, "transparency": _UNCHANGED, "disposal": 1}
        corner = int(part[1].start), int(part[0].start)
        for data in libs.gif.getdata(libs.image.fromarray(new, "P"), corner, **told):
            self._file.write(data)

    def close(self) -> None:
        """Write the end."""
        self._file.write(b";")

    def _indices(self, pixels: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint8]:
        """Where in the palette the colours nearest to those of pixels are."""
        codes = _codes(pixels)
        found = self._nearest[codes]
        unknown = found == _UNKNOWN
        if unknown.any():
            new = np.unique(codes[unknown])
            shifts = np.array([0, _BITS, 2 * _BITS])
            most = (1 << _BITS) - 1
            colours = np.round((new[:, None] >> shifts & most) * (255.0 / most))
            far = ((colours[:, None, :] - self._palette) ** 2).sum(axis=2)
            self._nearest[new] = far.argmin(axis=1)
            found = self._nearest[codes]
        return found.astype(np.uint8)


def _codes(pixels: npt.NDArray[np.uint32]) -> IntArray:
    """The first bits of red, green and blue, one beside the other."""
    parts = _bytes_of(pixels)[..., :3].astype(np.int64) >> 8 - _BITS
    return np.asarray(parts[..., 0] | parts[..., 1] << _BITS | parts[..., 2] << 2 * _BITS)


def _bytes_of(pixels: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint8]:
    """(..., 4)"""
    return np.ascontiguousarray(pixels).view(np.uint8).reshape(*pixels.shape, 4)


def extent(moving: npt.NDArray[np.bool_]) -> Part:
    """The smallest rectangle that holds all that is true, one pixel at least."""
    spans = []
    for across in (1, 0):
        there = np.flatnonzero(moving.any(axis=across))
        spans.append(slice(int(there[0]), int(there[-1]) + 1) if there.size else slice(0, 1))
    return spans[0], spans[1]


def _union(a: Part, b: Part) -> Part:
    """The smallest rectangle that holds both."""
    rows, columns = (slice(min(x.start, y.start), max(x.stop, y.stop)) for x, y in zip(a, b, strict=True))
    return rows, columns
