"""The axial force of a straight beam in its bending, from its modes: what ``Stiffening(axial_force="actual")`` adds.

    1/omega_a^2 integral of E A u_a' w_k' w_l' dx = G_a[k, l],    N = E A sum_a (q_a + q_b^T G_a q_b / 2) u_a'

With the static response to what presses a beam among its axial modes, N is exact for forces that change slowly, however
few modes there are: forces along x at both ends, where it is held and at its interfaces, and the centrifugal
load rho A (x - L/2) at 1 rad/s, of which a reaction takes what does not balance itself.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from lcpflex.bodies.body import Shortening
from lcpflex.bodies.fem.line_elements import LineModes, interpolate
from lcpflex.bodies.line_body import Line
from lcpflex.bodies.reduction.beam_stiffening import gauss, station_on
from lcpflex.bodies.reduction.line_interfaces import LineLoads
from lcpflex.bodies.reduction.stiffening import Stiffening
from lcpflex.jit.kernel import FloatArray

__all__ = ["shortening_of", "with_axial_loads"]


def with_axial_loads(line: Line, stiffening: Stiffening, loads: LineLoads) -> LineLoads:
    """The loads with those of the module besides. Raises ModelError for a place to hold it that is off the beam."""
    held = [] if stiffening.held is None else [station_on(line, "held", stiffening.held)]
    h = line.length / line.elements
    x, weight = gauss(line.nodes, 0.0, line.length)

    def spread(modes: LineModes) -> FloatArray:
        return np.asarray((weight * (x - 0.5 * line.length)) @ interpolate(modes, h, x)[0])

    places = np.unique([0.0, line.length, *held, *loads.stretch, *loads.bend[:, 0]])
    return loads._replace(stretch=places, spread=spread)


def shortening_of(line: Line, modes: LineModes, is_axial: npt.NDArray[np.bool_], rigidity: float) -> Shortening | None:
    """How the modes shorten the beam; None where none of them bend it. rigidity: E A [N]."""
    axial, bending = np.flatnonzero(is_axial), np.flatnonzero(~is_axial)
    if not (len(axial) and len(bending)):
        return None
    h = line.length / line.elements
    x, weight = gauss(line.nodes, 0.0, line.length)
    slope = interpolate(modes, h, x)[2][:, bending]
    tension = rigidity / h * np.diff(modes.stretch[:, axial], axis=0) / modes.omega2[axial]
    tension = tension[np.minimum((x / h).astype(np.int64), line.elements - 1)]
    matrices = np.array([slope.T @ ((weight * N)[:, None] * slope) for N in tension.T])
    return Shortening(axial, bending, np.asarray(0.5 * (matrices + matrices.transpose(0, 2, 1))))
