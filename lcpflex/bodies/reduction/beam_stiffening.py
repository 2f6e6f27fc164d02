"""Geometric stiffening of a straight beam, from the tension N along its axis: K_g = integral of N w' w' dx.

Spun at 1 rad/s about p on its axis, with both ends free,

    N(x) = rho A ((L - p)^2 - (x - p)^2) / 2  behind p,   rho A (p^2 - (p - x)^2) / 2  before it

which for p = L/2 has no jump: the tension of free flight. The axial force N0 between A and B, as
:mod:`lcpflex.bodies.reduction.stiffening` says, adds the integral of N0 (w' - s)^2 from A to B, s the slope of the
line A B.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.basics.blas import one_thread
from lcpflex.bodies.fem.line_elements import LineModes, interpolate
from lcpflex.bodies.line_body import Line
from lcpflex.bodies.reduction.damping import signed
from lcpflex.bodies.reduction.line_interfaces import station
from lcpflex.bodies.reduction.stiffening import Stiffening
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Axis

__all__ = [
    "axis_of",
    "bent_under_tension",
    "buckled",
    "gauss",
    "spinning",
    "spun",
    "station_on",
    "under_axial_force",
]


def spinning(line: Line, modes: LineModes, stiffening: Stiffening | None) -> FloatArray | None:
    """G (n, n) of the modes; None without stiffening or modes. Raises ModelError for a place off the beam."""
    if stiffening is None or not len(modes.omega2):
        return None
    x, weight = gauss(line.nodes, 0.0, _pivot(line, stiffening), line.length)
    tension = _spun(line, stiffening, x)
    slope = interpolate(modes, line.length / line.elements, x)[2]
    G = slope.T @ ((weight * tension)[:, None] * slope)
    return np.asarray(0.5 * (G + G.T))


def axis_of(line: Line, modes: LineModes, stiffening: Stiffening | None, rigidity: float) -> Axis:
    """What the axial force of the beam is compared with, at its nodes. rigidity: E I [N m^2]."""
    nodes = line.nodes
    spin, given = np.zeros_like(nodes), np.zeros_like(nodes)
    if stiffening is not None and not stiffening.actual:
        spin = _spun(line, stiffening, nodes)
    if stiffening is not None and stiffening.constant:
        a, b = sorted(station_on(line, "between", end) for end in stiffening.between)
        given[(nodes >= a) & (nodes <= b)] = stiffening.constant
    return Axis(
        length=line.length,
        euler=math.pi**2 * rigidity / line.length**2,
        station=nodes,
        slope=modes.rotation,
        spin=spin,
        given=given,
        actual=stiffening is not None and stiffening.actual,
    )


def _pivot(line: Line, stiffening: Stiffening) -> float:
    return 0.5 * line.length if stiffening.held is None else station_on(line, "held", stiffening.held)


def _spun(line: Line, stiffening: Stiffening, x: FloatArray) -> FloatArray:
    return spun(line.mass / line.length, (0.0, line.length), _pivot(line, stiffening), x)


def spun(density: float, ends: tuple[float, float], p: float, x: FloatArray) -> FloatArray:
    """N(x) at 1 rad/s [N s^2] of a beam of ``density`` [kg/m] between its ends, as the module has it."""
    reach = np.where(x < p, p - ends[0], ends[1] - p)
    return np.asarray(0.5 * density * (reach**2 - (x - p) ** 2))


def bent_under_tension(
    line: Line, omega2: FloatArray, deflection: FloatArray, rotation: FloatArray, stiffening: Stiffening, count: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The ``count`` lowest bending modes under the axial force, from all of those without it.

    omega2 (n,), deflection and rotation (nodes, n) as :func:`lcpflex.bodies.fem.line_elements.bending_modes` gives
    them.

    Raises
    ------
    ModelError
        For compression beyond the buckling load, or places that the beam does not have.
    """
    a, b = sorted(station_on(line, "between", end) for end in stiffening.between)
    h = line.length / line.elements
    modes = LineModes(omega2, np.zeros_like(deflection), deflection, rotation)
    ends = interpolate(modes, h, np.array([a, b]))[1]
    x, weight = gauss(line.nodes, a, b)
    slope = interpolate(modes, h, x)[2] - (ends[1] - ends[0]) / (b - a)
    loaded, turn = under_axial_force(omega2, slope, weight, stiffening.constant)
    turn = turn[:, :count]
    nodes = len(deflection)
    shapes = signed(np.vstack([deflection @ turn, rotation @ turn]), np.arange(2 * nodes) < nodes)
    return loaded[:count], shapes[:nodes], shapes[nodes:]


def under_axial_force(
    omega2: FloatArray, slope: FloatArray, weight: FloatArray, force: float
) -> tuple[FloatArray, FloatArray]:
    """omega2 (n,) under the force, and the combinations (n, n) of modes without it that are the modes then.

    slope (k, n) of the modes against the line of the force; weight (k,): the integral is force sum weight slope^2.

    Raises
    ------
    ModelError
        For compression beyond the buckling load.
    """
    # scaled by the frequencies, K is I and what is added is small for all but the lowest modes: few digits are lost
    scaled = slope / np.sqrt(omega2)
    relative = np.eye(len(omega2)) + force * (scaled.T @ (weight[:, None] * scaled))
    try:
        lower = np.linalg.cholesky(0.5 * (relative + relative.T))
    except np.linalg.LinAlgError:
        raise buckled(force) from None
    with one_thread(len(lower)):
        flexible = np.linalg.solve(lower, np.diag(1.0 / np.sqrt(omega2)))
        _, periods, turn = np.linalg.svd(flexible)
    return periods**-2, turn.T


def buckled(force: float) -> ModelError:
    """What is said of compression that the beam does not bear."""
    return ModelError(f"axial_force: {shown(force)} was given, expected less compression: the beam buckles under it")


def station_on(line: Line, name: str, held: object) -> float:
    """Where along the beam a place lies."""
    return station(name, held, line.length, line.thickness)  # type: ignore[arg-type]  # as Stiffening has checked


def gauss(nodes: FloatArray, first: float, *later: float) -> tuple[FloatArray, FloatArray]:
    """Stations and weights of four Gauss points between nodes and the given places: exact to degree 7 in each piece."""
    places = np.unique([first, *later])
    breaks = np.unique(np.concatenate([places, nodes[(nodes > places[0]) & (nodes < places[-1])]]))
    place, weight = np.polynomial.legendre.leggauss(4)
    half = 0.5 * np.diff(breaks)
    stations = breaks[:-1, None] + half[:, None] * (place + 1.0)
    return stations.ravel(), (half[:, None] * weight).ravel()
