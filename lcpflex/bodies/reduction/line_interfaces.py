"""Residual modes of beams and bars: what static loads at interfaces bend, beyond the free modes that are kept.

Of all modes phi_k of the free line, a unit load f that its inertia balances bends those that are left out by

    sum over k left out of phi_k (phi_k . f) / omega_k^2

With them, the static compliance at an interface is that of the mesh. Two sets of loads with the same response make one
mode: what adds less than DEPENDENT^2 to the compliance is dropped. Source: MacNeal 1971; Rubin 1975.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.basics.blas import one_thread
from lcpflex.bodies.fem.line_elements import LineModes, interpolate
from lcpflex.bodies.reduction.interface import Interface
from lcpflex.bodies.reduction.stiffening import place_of
from lcpflex.errors import in_range
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["LineLoads", "LineStatics", "joined", "line_loads", "residual_line", "residual_modes", "station", "taken"]

BoolArray: TypeAlias = npt.NDArray[np.bool_]

DEPENDENT = 1e-5  # square root of the share of the compliance that a mode must add
NOTHING = 1e-12  # of the largest load: one that moves no mode
ALONG = 1e-9  # a direction with less than this part along the line, or across it, has none


class LineLoads(NamedTuple):
    """Unit loads on a line, each once."""

    stretch: FloatArray  # (k,) places of forces along it [m]
    bend: FloatArray  # (m, 3) places [m] of forces across it, with their force and moment
    spread: Callable[[LineModes], FloatArray] | None = None  # what a load spread along it does on its modes (k,)

    def any(self) -> bool:
        """Whether there is one."""
        return bool(len(self.stretch) or len(self.bend) or self.spread)


def line_loads(length: float, thickness: float, interfaces: Sequence[Interface]) -> LineLoads:
    """The loads of the interfaces. A force beside the axis is one on it and a moment: -y f_x.

    Raises
    ------
    ModelError
        For what is no place of the line.
    """
    stretch: set[float] = set()
    bend: set[tuple[float, float, float]] = set()
    for k, interface in enumerate(interfaces):
        at: Any = interface.place
        x, y = _on_line(f"interfaces[{k}]", (at, 0.0) if isinstance(at, (int, float)) else at, length, thickness)
        if interface.forces:
            _add_forces(stretch, bend, (x, y), interface.along, ALONG * length)
        if interface.moment:
            bend.add((x, 0.0, 1.0))
    return LineLoads(np.array(sorted(stretch)), np.array(sorted(bend)).reshape(-1, 3))


def _add_forces(
    stretch: set[float],
    bend: set[tuple[float, float, float]],
    place: tuple[float, float],
    along: tuple[float, ...] | None,
    least: float,
) -> None:
    """Forces at a place of the line, in one direction or in all; levers below ``least`` [m] are none."""
    x, y = place
    if along is None:
        stretch.add(x)
        bend.add((x, 1.0, 0.0))
        if abs(y) > least:
            bend.add((x, 0.0, 1.0))
        return
    fx, fy = along
    if abs(fx) > ALONG:
        stretch.add(x)
    if abs(fy) > ALONG or abs(y * fx) > least:
        sign = math.copysign(1.0, fy if abs(fy) > ALONG else -y * fx)  # one load, whichever way it points
        bend.add((x, sign * fy, -sign * y * fx))


def station(name: str, place: str | npt.ArrayLike, length: float, thickness: float) -> float:
    """Where along a line a place lies, a name or (x, y). Raises ModelError for one off the line."""
    return _on_line(name, place, length, thickness)[0]


def _on_line(name: str, place: str | npt.ArrayLike, length: float, thickness: float) -> tuple[float, float]:
    ends: dict[str, tuple[float, ...]] = {"left": (0.0, 0.0), "center": (0.5 * length, 0.0), "right": (length, 0.0)}
    x, y = place_of(name, place, ends)
    slack = 1e-12 * length
    in_range(f"{name}: y", y, -0.5 * thickness - slack, 0.5 * thickness + slack)
    return min(max(in_range(f"{name}: x", x, -slack, length + slack), 0.0), length), y


def residual_modes(omega2: FloatArray, loads: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Residual modes in terms of the modes that are left out.

    omega2 (k,) of these; loads (k, m): what each of m unit loads does on them. Returns omega2 (r,) [rad^2/s^2],
    ascending, and the combinations (k, r), orthonormal, in which the stiffness is diagonal.
    """
    soft = 1.0 / np.sqrt(omega2)
    energy = soft[:, None] * loads  # the compliance is energy^T energy
    size = np.linalg.norm(energy, axis=0)
    energy = energy[:, size > NOTHING * size.max(initial=0.0)]
    if not energy.size:
        return np.zeros(0), np.zeros((len(omega2), 0))
    with one_thread(len(energy)):
        span, share, _ = np.linalg.svd(energy / np.linalg.norm(energy, axis=0), full_matrices=False)
        # displacements of unit energy: where their mass is diagonal, too, it is 1/omega^2
        turn, period, _ = np.linalg.svd(soft[:, None] * span[:, share > DEPENDENT * share[0]], full_matrices=False)
    return np.asarray(period**-2.0), np.asarray(turn)


def taken(modes: LineModes, which: IntArray | slice) -> LineModes:
    """Some of the modes."""
    return LineModes(*(np.asarray(part[..., which]) for part in modes))


def joined(*parts: LineModes) -> LineModes:
    """Modes of one line, one part after the other."""
    return LineModes(*(np.concatenate(columns, axis=-1) for columns in zip(*parts, strict=True)))


def residual_line(left: LineModes, is_axial: BoolArray, h: float, loads: LineLoads) -> tuple[LineModes, BoolArray]:
    """Residual modes of the loads, of modes ``left`` out; and which of them stretch.

    h: length of an element [m]. Bending and stretching stay apart.
    """
    parts, axial = [], []
    for stretching in (False, True):
        own = taken(left, np.flatnonzero(is_axial == stretching))
        omega2, turn = residual_modes(own.omega2, _on_modes(own, h, loads, stretching).T)
        parts.append(LineModes(omega2, *(shape @ turn for shape in own[1:])))
        axial.append(np.full(len(omega2), stretching))
    both = joined(*parts)
    order = np.argsort(both.omega2, kind="stable")
    return taken(both, order), np.concatenate(axial)[order]


def _on_modes(modes: LineModes, h: float, loads: LineLoads, stretching: bool) -> FloatArray:
    """(loads, n) what each load does on each mode."""
    if stretching:
        pulled = interpolate(modes, h, loads.stretch)[0]
        return np.vstack([pulled, loads.spread(modes)]) if loads.spread else pulled
    place, force, moment = loads.bend.T[:, :, None]
    _, deflection, slope = interpolate(modes, h, place[:, 0])
    return np.asarray(force * deflection + moment * slope)


class LineStatics:
    """Static compliance of a whole line, from all of its modes, which are made when they are first asked for."""

    def __init__(self, modes: Callable[[], LineModes], length: float) -> None:
        self._make = modes
        self._length = length
        self._modes: LineModes | None = None
        self.known: dict[Any, Any] = {}

    def compliance(self, *place: Any) -> FloatArray:
        """(3, 3) displacement (x, y) [m] and rotation [rad] at a place by unit forces and a unit moment there."""
        loads, omega2 = self._at(*place)
        return np.asarray(loads.T @ (loads / omega2[:, None]))

    def enough(self, place: tuple[Any, ...], rows: FloatArray, share: float) -> int:
        """How many free modes miss at most ``share`` of the compliance in the rows (3, k) at a place."""
        loads, omega2 = self._at(*place)
        part = np.sum((loads @ rows) ** 2, axis=1) / omega2
        order = np.argsort(omega2, kind="stable")
        missing = np.sum(part) - np.cumsum(part[order])
        return int(np.searchsorted(-missing, -share * np.sum(part))) + 1

    def _at(self, x: float, y: float) -> tuple[FloatArray, FloatArray]:
        """(n, 3) what unit loads at a place do on each mode, and omega2 (n,)."""
        if self._modes is None:
            self._modes = self._make()
        h = self._length / (len(self._modes.stretch) - 1)
        u, w, slope = (part[0] for part in interpolate(self._modes, h, np.array([x])))
        return np.column_stack([u - y * slope, w, slope]), self._modes.omega2
