"""GIF films of frames that are mostly the same: one palette for all, colours looked for where something has changed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import IO, TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs

if TYPE_CHECKING:
    from lcpflex.jit.kernel import IntArray

__all__ = ["Part", "Pixels", "extent", "palette_of", "write_gif"]

Pixels = npt.NDArray[np.uint32]  # (rows, columns), the bytes of each pixel red, green, blue, alpha
Part = tuple[slice, slice]  # rows and columns of pixels

_COLOURS = 255  # of the palette: one is left for what does not change from frame to frame
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
    found = libs.image.fromarray(seen).quantize(_COLOURS - len(kept), libs.image.Quantize.FASTOCTREE)
    others = np.array(found.getpalette()).reshape(-1, 3)
    return np.resize(np.concatenate([kept, others]), (_COLOURS, 3)).astype(np.uint8)


def write_gif(
    file: IO[bytes], still: Pixels, frames: Iterable[Pixels], palette: npt.NDArray[np.uint8], seconds: float
) -> None:
    """Write a film that goes on for ever.

    Parameters
    ----------
    file
        Open for bytes.
    still
        (rows, columns) what of all frames does not move.
    frames
        One after the other; each is read before the next one is asked for.
    palette
        Colours for all frames, of :func:`palette_of`.
    seconds
        How long a frame is shown, in hundredths at best.
    """
    nearest = _Nearest(palette)
    ground = nearest(still)

    def pictures() -> Iterator[Any]:
        for frame in frames:
            moving = frame != still
            indices = ground.copy()
            indices[moving] = nearest(frame[moving])
            picture = libs.image.fromarray(indices)
            picture.putpalette(palette.tobytes())
            yield picture

    first, *others = pictures()
    shown: dict[str, Any] = {"duration": round(1000.0 * seconds), "loop": 0, "disposal": 1}  # what is there stays
    first.save(file, "GIF", save_all=True, append_images=others, optimize=True, **shown)


class _Nearest:
    """The index in a palette of the colour nearest to that of a pixel: by the first bits of each, looked for once."""

    def __init__(self, palette: npt.NDArray[np.uint8]) -> None:
        self._palette = palette.astype(np.int64)
        self._nearest = np.full(1 << 3 * _BITS, _UNKNOWN, np.int16)

    def __call__(self, pixels: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint8]:
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
