"""Residual modes of beams and bars: what static loads at interfaces bend, beyond the free modes that are kept.

Of all modes phi_k of the free line, a unit load f that its inertia balances bends those that are left out by

    sum over k left out of phi_k (phi_k . f) / omega_k^2

With them, the static compliance at an interface is that of the mesh. Two sets of loads with the same response make one
mode: what adds less than DEPENDENT^2 to the compliance is dropped. Source: MacNeal 1971; Rubin 1975.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from lcpflex.bodies.body import array_of
from lcpflex.bodies.line_mesh import LineModes, interpolate
from lcpflex.bodies.stiffening import place_of
from lcpflex.compiled import FloatArray, IntArray
from lcpflex.errors import ModelError, in_range

__all__ = ["Interfaces", "residual_line", "residual_modes", "station", "stations_of", "taken"]

BoolArray: TypeAlias = npt.NDArray[np.bool_]
Interfaces: TypeAlias = Sequence[str | float | tuple[float, float]]

DEPENDENT = 1e-5  # square root of the share of the compliance that a mode must add
NOTHING = 1e-12  # of the largest load: one that moves no mode


def stations_of(length: float, thickness: float, interfaces: Interfaces) -> FloatArray:
    """Where along the line the interfaces lie (k,), ascending, each once.

    Raises
    ------
    ModelError
        For what is no place of the line.
    """
    if isinstance(interfaces, str) or not isinstance(interfaces, Sequence):
        raise ModelError(
            f"interfaces: {interfaces!r} was given, expected a list of places: 'left', 'center', 'right', x or (x, y)"
        )
    found = []
    for k, place in enumerate(interfaces):
        name = f"interfaces[{k}]"
        at = (place, 0.0) if isinstance(place, (int, float)) and not isinstance(place, bool) else place
        found.append(station(name, at if isinstance(at, str) else array_of(name, at, (2,)), length, thickness))
    return np.unique(found)


def station(name: str, place: str | npt.ArrayLike, length: float, thickness: float) -> float:
    """Where along a line a place lies, a name or (x, y). Raises ModelError for one off the line."""
    ends = {"left": (0.0, 0.0), "center": (0.5 * length, 0.0), "right": (length, 0.0)}
    x, y = place_of(name, place, ends)
    slack = 1e-12 * length
    in_range(f"{name}: y", y, -0.5 * thickness - slack, 0.5 * thickness + slack)
    return min(max(in_range(f"{name}: x", x, -slack, length + slack), 0.0), length)


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
    span, share, _ = np.linalg.svd(energy / np.linalg.norm(energy, axis=0), full_matrices=False)
    # displacements of unit energy: where their mass is diagonal, too, it is 1/omega^2
    turn, period, _ = np.linalg.svd(soft[:, None] * span[:, share > DEPENDENT * share[0]], full_matrices=False)
    return np.asarray(period**-2.0), np.asarray(turn)


def taken(modes: LineModes, which: IntArray) -> LineModes:
    """Some of the modes."""
    return LineModes(*(np.asarray(part[..., which]) for part in modes))


def residual_line(
    left: LineModes,
    is_axial: BoolArray,
    h: float,
    stations: FloatArray,
    along: Callable[[LineModes], FloatArray] | None = None,
) -> tuple[LineModes, BoolArray]:
    """Residual modes of forces and moments at the stations, of modes ``left`` out; and which of them stretch.

    h: length of an element [m]; along: what other loads along the line do on modes, instead of those at the stations:
    (modes, loads). Bending and stretching stay apart: a force beside the axis is one on it and a moment.
    """
    parts, axial = [], []
    for stretching in (False, True):
        own = taken(left, np.flatnonzero(is_axial == stretching))
        stretch, deflection, slope = interpolate(own, h, stations)
        if stretching:
            loads = along(own) if along else stretch.T
        else:
            loads = np.concatenate([deflection, slope]).T
        omega2, turn = residual_modes(own.omega2, loads)
        parts.append(LineModes(omega2, *(shape @ turn for shape in own[1:])))
        axial.append(np.full(len(omega2), stretching))
    both = LineModes(*(np.concatenate(pair, axis=-1) for pair in zip(*parts, strict=True)))
    order = np.argsort(both.omega2, kind="stable")
    return taken(both, order), np.concatenate(axial)[order]
