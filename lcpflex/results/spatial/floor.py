"""The floor under a spatial scene with its grid, and the axes along its borders."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics import libs

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.spatial.camera import Camera

__all__ = ["AXIS_COLOURS", "OUTSIDE", "Floor", "Scale", "draw_floor", "floor_under", "scales", "thinned"]

AXIS_COLOURS = ("#B2182B", "#1B7837", "#2166AC")  # of x, y and z
_GROUND, _LINE, _WORDS = "#F4F4F2", "#C9C9C6", "#404040"
_THIN = 0.3  # least extent along the floor, relative to the largest
_BELOW = 0.02  # of the extent, between the floor and what is above it
_CELLS = 7.0  # of the grid along the longest side, about
_SEEN = 0.2  # share of its length, under which a border is seen too obliquely for numbers
_OUT = 7.0  # from a border to its numbers, points
_NAME = 26.0  # and to its name
_LETTER, _HIGH, _BETWEEN = 4.5, 9.0, 4.0  # width and height of small letters, and room between two texts, points
OUTSIDE = 46.0  # and to where the picture may end


class Floor(NamedTuple):
    """A rectangle at the height low[2], and how high the scene rises over it, along the rows of ``Camera.floor``."""

    low: FloatArray  # (3,) [m]
    high: FloatArray  # (3,)
    step: float  # of the grid

    def corners(self) -> FloatArray:
        """(4, 3) around the floor."""
        (x0, y0, z), (x1, y1, _) = self.low, self.high
        return np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])


class Scale(NamedTuple):
    """A line with numbers in the picture."""

    line: FloatArray  # (2, 2) its ends
    out: FloatArray  # (2,) direction from it to its numbers
    numbers: list[tuple[float, FloatArray]]  # value and place of each
    name: str
    colour: str


def floor_under(low: FloatArray, high: FloatArray, level: float | None = None) -> Floor:
    """The floor of a scene between two corners (3,), along the rows of ``Camera.floor``.

    It is at the height ``level`` [m]; without one a little below the scene.
    """
    extent = max(float((high - low).max()), 1e-9)
    step = _round_step(extent / _CELLS)
    middle, half = 0.5 * (low + high)[:2], 0.5 * (high - low)[:2]
    half = np.maximum(half, 0.5 * _THIN * extent) + 0.25 * step
    first, last = np.floor((middle - half) / step) * step, np.ceil((middle + half) / step) * step
    bottom = low[2] - _BELOW * extent if level is None else level
    return Floor(np.append(first, bottom), np.append(last, max(high[2], bottom + 0.5 * step)), step)


def draw_floor(ax: Axes, floor: Floor, camera: Camera, point: float) -> None:
    """The floor, its grid, and numbers along two borders and up from the leftmost corner.

    point: length of a point of the page [m].
    """
    seen = _on_picture(floor.corners(), camera)
    ax.add_patch(libs.Polygon(seen, facecolor=_GROUND, edgecolor=_LINE, linewidth=0.8, zorder=0))
    lines = []
    for along in (0, 1):
        for value in _ticks(floor, along)[1:-1]:
            ends = np.array([floor.low, floor.low])
            ends[:, along], ends[1, 1 - along] = value, floor.high[1 - along]
            lines.append(_on_picture(ends, camera))
    ax.add_collection(libs.LineCollection(lines, colors=_LINE, linewidths=0.6, zorder=0.1))
    for scale in scales(floor, camera):
        ax.plot(*scale.line.T, color=_WORDS, linewidth=0.8, zorder=0.2)
        texts, name = thinned(scale, floor.step, point)
        for text, place in texts:
            _beside(ax, text, place, scale.out, _OUT, fontsize="x-small", color=_WORDS)
        _beside(ax, scale.name, scale.line.mean(axis=0), scale.out, name, fontsize="small", color=scale.colour)


def thinned(scale: Scale, step: float, point: float) -> tuple[list[tuple[str, FloatArray]], float]:
    """Numbers of a scale that do not run into each other, and how far its name is beyond them [points].

    Every number, or every second, fifth, tenth of those that are multiples of as many steps.
    """
    texts = [(_digits(value, step), place) for value, place in scale.numbers]
    widest = _LETTER * max((len(text) for text, _ in texts), default=0)
    beyond = abs(float(scale.out[0])) * widest + abs(float(scale.out[1])) * _HIGH
    name = max(_NAME, _OUT + beyond + _BETWEEN)
    if len(texts) < 2:
        return texts, name
    apart = np.abs(texts[1][1] - texts[0][1]) / point
    needed = min((widest + _BETWEEN) / max(apart[0], 1e-9), _HIGH / max(apart[1], 1e-9))
    every = next((k for k in (1, 2, 5, 10) if k >= needed), 20)
    counts = [round(value / step) for value, _ in scale.numbers]
    return [text for text, count in zip(texts, counts, strict=True) if count % every == 0], name


def scales(floor: Floor, camera: Camera) -> list[Scale]:
    """Those of two borders of the floor, the lower ones in the picture, and of the height, unless seen obliquely."""
    upward, towards = camera.floor @ camera.upward, camera.floor @ camera.towards
    lower = np.where(np.abs(upward) > 1e-9, upward < 0.0, towards >= 0.0)  # in the picture: where nothing hides it
    found = [_border(floor, camera, along, bool(lower[1 - along])) for along in (0, 1)]
    return [scale for scale in (*found, _height(floor, camera)) if scale is not None]


def _border(floor: Floor, camera: Camera, along: int, last: bool) -> Scale | None:
    """Along the floor axis ``along``, at the last or first border across it."""
    ends, outward = np.array([floor.low, floor.low]), np.zeros(3)
    ends[1, along] = floor.high[along]
    ends[:, 1 - along] = (floor.high if last else floor.low)[1 - along]
    outward[1 - along] = 1.0 if last else -1.0
    line, away = _on_picture(ends, camera), _on_picture(outward, camera)
    length = float(np.linalg.norm(line[1] - line[0]))
    if length < _SEEN * (floor.high - floor.low)[along]:
        return None
    across = np.array([line[0, 1] - line[1, 1], line[1, 0] - line[0, 0]]) / length  # straight away from the border
    side = float(across @ away)
    if side < -1e-9 or (side < 1e-9 and across[1] > 0.0):
        across = -across
    values = _ticks(floor, along)
    shares = np.linspace(0.0, 1.0, len(values))[:, None]
    numbers = list(zip(values.tolist(), line[0] + shares * (line[1] - line[0]), strict=True))
    return _scale(camera, along, line, across, numbers[1:-1])  # at the corners those of two borders would meet


def _height(floor: Floor, camera: Camera) -> Scale | None:
    """Up from the corner of the floor that is leftmost in the picture."""
    corners = floor.corners()
    foot = corners[np.argmin(_on_picture(corners, camera)[:, 0])]
    line = _on_picture(np.array([foot, [foot[0], foot[1], floor.high[2]]]), camera)
    height = float(floor.high[2] - floor.low[2])
    if np.linalg.norm(line[1] - line[0]) < _SEEN * height:
        return None
    first, last = np.ceil(floor.low[2] / floor.step - 1e-6), np.floor(floor.high[2] / floor.step + 1e-6)
    values = floor.step * np.arange(first, last + 1.0)
    places = line[0] + (values[:, None] - floor.low[2]) / height * (line[1] - line[0])
    numbers = list(zip((camera.sign * values).tolist(), places, strict=True))
    return _scale(camera, 2, line, np.array([-1.0, 0.0]), numbers)


def _scale(
    camera: Camera, row: int, line: FloatArray, out: FloatArray, numbers: list[tuple[float, FloatArray]]
) -> Scale:
    axis = int(camera.axes[row])
    return Scale(line, out, numbers, f"{'xyz'[axis]} [m]", AXIS_COLOURS[axis])


def _digits(value: float, step: float) -> str:
    """A multiple of the step, with no more digits than tell it from the next."""
    digits = max(0, -int(np.floor(np.log10(step) + 1e-9)))
    text = f"{value:.{digits}f}" if 1e-4 < step < 1e5 else f"{value:.4g}"
    return text.lstrip("-") if float(text) == 0.0 else text


def _beside(ax: Axes, text: str, place: FloatArray, out: FloatArray, points: float, **style: Any) -> None:
    """A text so many points from a place in the direction ``out`` (2,)."""
    side = "right" if out[0] < -0.6 else "left" if out[0] > 0.6 else "center"
    level = "top" if out[1] < -0.6 else "bottom" if out[1] > 0.6 else "center"
    ax.annotate(
        text, tuple(place), tuple(points * out), textcoords="offset points", ha=side, va=level, zorder=0.3, **style
    )


def _ticks(floor: Floor, along: int) -> FloatArray:
    """Multiples of the step along a side of the floor, its ends included."""
    count = round((floor.high[along] - floor.low[along]) / floor.step)
    return np.asarray(floor.low[along] + floor.step * np.arange(count + 1))


def _on_picture(places: FloatArray, camera: Camera) -> FloatArray:
    """(..., 2) of places (..., 3) along the rows of ``Camera.floor``."""
    return camera.seen(places @ camera.floor)[..., :2]


def _round_step(about: float) -> float:
    power = 10.0 ** np.floor(np.log10(about))
    return float(min((c * power for c in (1.0, 2.0, 5.0, 10.0)), key=lambda step: abs(np.log(step / about))))
