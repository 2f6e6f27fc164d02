"""What contacts do in an impact: the laws of Newton, Poisson and Stronge, as values.

e_N is the restitution that each contact declares. Contacts that are closed take part, whether they approach or not:
all at once or, with ``sequential``, one after another, the one that approaches fastest first, until none approaches. A
chain of impacts that has not ended after 1000 is ended by one without restitution.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from lcpflex.basics.options import keep_flag

__all__ = ["ENERGETIC", "NEWTON", "POISSON", "Stronge", "ImpactLaw", "Newton", "Poisson"]

NEWTON, POISSON, ENERGETIC = 0, 1, 2  # the same for kernels


@dataclass(frozen=True, slots=True)
class Newton:
    """Normal velocities are reflected, gdot_N+ = -e_N gdot_N-, and tangential ones with e_T (Moreau 1988).

        0 <= p_N  _|_  gdot_N+ + e_N gdot_N- >= 0,   p_T in mu p_N Sign(-(gdot_T+ + e_T gdot_T-))

    With friction it may create energy (Kane's double pendulum); the result says so.

    sequential: whether the contacts of one instant are struck one after another, and not all at once.
    """

    sequential: bool = False
    code: ClassVar[int] = NEWTON

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

    def __post_init__(self) -> None:
        keep_flag(self, "sequential")


ImpactLaw: TypeAlias = Newton | Poisson | Stronge
