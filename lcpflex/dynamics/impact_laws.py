"""What contacts do in an impact: the laws of Newton, Poisson and Stronge, as values and as kernels ask for them.

e_N is the restitution that each contact declares. Contacts that are closed take part, whether they approach or not:
all at once or, with ``sequential``, one after another, the one that approaches fastest first, until none approaches. A
chain of impacts that has not ended after 1000 is ended by one without restitution.

To add a law, all in this file: its class, its name in ``ImpactLaw``, and where its ``code`` counts: among the laws that
reflect velocities, those that give impulses back, or those that integrate the impact of one contact, which have a
branch in :func:`impact_phases`.

Sources: Pfeiffer & Glocker 1996; Stronge 1990.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, TypeAlias, get_args

from lcpflex.basics.options import keep_flag
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.memory import ContactData

__all__ = [
    "KNOWN",
    "SEGMENTS",
    "ImpactLaw",
    "Newton",
    "Poisson",
    "Stronge",
    "energetic_segments",
    "gives_back",
    "impact_phases",
    "integrates",
    "reflects",
]

NEWTON, POISSON, ENERGETIC = 0, 1, 2  # the same for kernels
SEGMENTS = 8  # slip, stick or slip back; compression, restitution: at most four in all


@dataclass(frozen=True, slots=True)
class Newton:
    """Normal velocities are reflected, gdot_N+ = -e_N gdot_N-, and tangential ones with e_T (Moreau 1988).

        0 <= p_N  _|_  gdot_N+ + e_N gdot_N- >= 0,   p_T in mu p_N Sign(-(gdot_T+ + e_T gdot_T-))

    With friction it may create energy (Kane's double pendulum); the result says so.

    sequential: whether the contacts of one instant are struck one after another, and not all at once.
    """

    sequential: bool = False
    code: ClassVar[int] = NEWTON
    tangential: ClassVar[bool] = True  # whether it knows tangential restitution

    def __post_init__(self) -> None:
        keep_flag(self, "sequential")


@dataclass(frozen=True, slots=True)
class Poisson:
    """Impulses are reflected, in two contact problems (Pfeiffer & Glocker 1996).

        compression   0 <= p_C  _|_  gdot_N,C >= 0
        expansion     0 <= p_E - e_N p_C  _|_  gdot_N,E >= 0

    each with Coulomb friction of its own. Contacts that touched without approaching rebound, too, and none is left
    approaching. Declared tangential restitution is refused.

    sequential: whether the contacts of one instant are struck one after another, and not all at once.
    """

    sequential: bool = False
    code: ClassVar[int] = POISSON
    tangential: ClassVar[bool] = False  # whether it knows tangential restitution

    def __post_init__(self) -> None:
        keep_flag(self, "sequential")


@dataclass(frozen=True, slots=True)
class Stronge:
    """The work of the normal impulse: in restitution it gives back e_N^2 of what compression took (Stronge 1990).

    The velocities are integrated over the normal impulse p of one contact, through slip, stick and reversed slip, each
    of which has constant rates:

        d gdot_N / dp = G_NN + kappa G_NT,   d gdot_T / dp = G_TN + kappa G_TT,
        kappa = -mu sign(gdot_T) in slip, -G_TN / G_TT in stick, possible if |G_TN| <= mu G_TT

    Energy never grows for e_N <= 1. If contacts that influence each other close together, the run ends by a StepError,
    unless ``sequential``. Declared tangential restitution is refused.
    """

    sequential: bool = False
    code: ClassVar[int] = ENERGETIC
    tangential: ClassVar[bool] = False  # whether it knows tangential restitution

    def __post_init__(self) -> None:
        keep_flag(self, "sequential")


ImpactLaw: TypeAlias = Newton | Poisson | Stronge
KNOWN = " or ".join(", ".join(f"{law.__name__}()" for law in get_args(ImpactLaw)).rsplit(", ", 1))  # for messages


@kernel
def reflects(law: int) -> bool:
    """Whether a law reflects the velocities before an impact."""
    return law == NEWTON


@kernel
def gives_back(law: int) -> bool:
    """Whether a law gives impulses of compression back in a second contact problem."""
    return law == POISSON


@kernel
def integrates(law: int) -> bool:
    """Whether a law integrates the impact of one contact over its normal impulse, by :func:`impact_phases`."""
    return law == ENERGETIC


@kernel
def impact_phases(law: int, problem: ContactData, restitution: float, segments: FloatArray) -> int:
    """Impulses of the only contact of a problem, phase by phase; returned as by :func:`energetic_segments`."""
    gnt, gtt, v_t, mu = 0.0, 0.0, 0.0, 0.0
    v_n = min(problem.free[0], 0.0)
    if problem.n_tangents > 0:
        gnt, gtt = problem.delassus[0, 1], problem.delassus[1, 1]
        v_t, mu = problem.free[1], problem.friction[0]
        if abs(v_t) <= 1e-14 * abs(v_n):
            v_t = 0.0
    if law == ENERGETIC:
        return energetic_segments(problem.delassus[0, 0], gnt, gtt, v_n, v_t, mu, restitution, segments)
    return -1


@kernel
def energetic_segments(
    gnn: float, gnt: float, gtt: float, v_n: float, v_t: float, mu: float, e: float, segments: FloatArray
) -> int:
    """Impulses of one contact by Stronge's law, phase by phase.

    gnn, gnt, gtt: Delassus operator of the contact; v_n <= 0 and v_t: its velocities [m/s]. Out: segments (SEGMENTS, 2)
    normal and tangential impulse [N s] of each phase of constant rates. Returns their number; -1 if compression does
    not end (G is not positive definite).
    """
    taken = 0.0  # work of the normal impulse since the present of its two phases began
    due = 0.0  # what restitution has to give back
    restitution = False
    slip = 0.0
    if mu > 0.0 and v_t != 0.0:
        slip = 1.0 if v_t > 0.0 else -1.0
    for count in range(SEGMENTS):
        ratio = -mu * slip
        if slip == 0.0 and mu > 0.0:
            if abs(gnt) <= mu * gtt:
                ratio = -gnt / gtt
            else:
                slip = 1.0 if gnt > 0.0 else -1.0
                ratio = -mu * slip
        rate_n = gnn + ratio * gnt
        rate_t = gnt + ratio * gtt
        stop = math.inf
        if slip * rate_t < 0.0:
            stop = max(-v_t / rate_t, 0.0)
        end = math.inf
        if restitution:
            rest = max(due - taken, 0.0)
            end = 2.0 * rest / (v_n + math.sqrt(v_n * v_n + 2.0 * rate_n * rest)) if rest > 0.0 else 0.0
        elif rate_n > 0.0:
            end = -v_n / rate_n
        p = min(stop, end)
        if not p < math.inf:
            return -1
        segments[count, 0] = p
        segments[count, 1] = ratio * p
        taken += (v_n + 0.5 * rate_n * p) * p
        v_n += rate_n * p
        v_t += rate_t * p
        if stop <= end:
            v_t = 0.0
            slip = 0.0
        if end <= stop:
            if restitution:
                return count + 1
            restitution = True
            v_n = 0.0
            due = -e * e * taken
            taken = 0.0
    return -1
