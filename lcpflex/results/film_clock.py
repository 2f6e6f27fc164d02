"""The time above a film, put together of digits that are drawn once: letters are the dear part of a frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.results.gif import Part, Pixels, extent

if TYPE_CHECKING:
    import numpy.typing as npt
    from matplotlib.axes import Axes

    from lcpflex.jit.kernel import FloatArray

__all__ = ["Clock"]

_FIRST = "t = "
_ABOVE = 1.01  # of the height of the axes


class Clock:
    """``t = 0.1234 s, 10 times slower`` in the upper left corner of a film; ``words``: what follows the number.

    What is the same in all frames is drawn onto the canvas at once.
    """

    def __init__(self, canvas: Any, axes: Axes, times: FloatArray, words: str) -> None:
        self._canvas, self._axes = canvas, axes
        self._left = round(float(axes.get_window_extent().x0))
        self._text = axes.text(0.0, _ABOVE, "0", transform=axes.transAxes, va="bottom", fontsize="medium")
        numbers = [f"{t:.4f}" for t in times]
        width = max(map(len, numbers))
        self._numbers = [number.rjust(width) for number in numbers]
        longest = f"{_FIRST}{'0' * (width - 5)}.0000"
        self._columns = [self._after(longest[: len(_FIRST) + k]) for k in range(width)]
        self._digits = {digit: self._picture(digit) for digit in sorted({*"".join(numbers)})}
        self._draw(_FIRST, self._left)
        self._draw(words, self._after(longest + " "))
        self._text.remove()

    def show(self, pixels: Pixels, frame: int) -> None:
        """Write the time of a frame into its pixels."""
        for column, digit in zip(self._columns, self._numbers[frame], strict=True):
            if digit != " ":
                (rows, columns), inked, colours = self._digits[digit]
                shift = column - self._left
                pixels[rows, columns.start + shift : columns.stop + shift][inked] = colours

    def _after(self, words: str) -> int:
        """The column of the pixels at which what follows the words begins."""
        return self._left + round(self._width(f"{words}0") - self._width("0"))

    def _width(self, words: str) -> float:
        """[pixels]"""
        self._text.set_text(words)
        return float(self._text.get_window_extent(self._canvas.get_renderer()).width)

    def _draw(self, words: str, column: int) -> None:
        box = self._axes.get_window_extent()
        self._text.set(text=words, x=(column - box.x0) / box.width)
        self._axes.draw_artist(self._text)

    def _picture(self, digit: str) -> tuple[Part, npt.NDArray[np.bool_], npt.NDArray[np.uint32]]:
        """Where its ink is, which pixels these are, and their colours; the canvas stays as it was."""
        pixels: Pixels = np.asarray(self._canvas.buffer_rgba()).view(np.uint32)[..., 0]
        blank = pixels.copy()
        self._draw(digit, self._left)
        inked = pixels != blank
        place = extent(inked)
        found = place, inked[place], pixels[inked]
        pixels[:] = blank
        return found
