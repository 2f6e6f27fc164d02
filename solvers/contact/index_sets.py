"""Contacts that are known to slide, and which way: their friction is a part of the columns of their normals.

The contacts that may stick have a tangential unknown; a sliding one has none, lambda_T = -mu sign(gdot_T) lambda_N.
Source: Pfeiffer & Glocker 1996.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.contact.memory import ContactData

__all__ = ["SLIDE_BACK", "SLIDE_FORTH", "SMOOTH", "STICKING", "reduce_columns", "sliding_sign"]

SMOOTH = 0  # no friction
STICKING = 1  # tangential unknown: gddot_T = 0, or in the LCP the law of friction
SLIDE_FORTH = 2  # gdot_T > 0 (or about to be): lambda_T = -mu lambda_N
SLIDE_BACK = 3  # gdot_T < 0: lambda_T = +mu lambda_N


@kernel
def sliding_sign(mode: int) -> float:
    """Sign of gdot_T of a sliding contact; 0 of another one."""
    if mode == SLIDE_FORTH:
        return 1.0
    return -1.0 if mode == SLIDE_BACK else 0.0


@kernel
def reduce_columns(
    data: ContactData,
    mode: IntArray,
    tangent_of: IntArray,
    sliding: bool,
    sticking: bool,
    stick: IntArray,
    reduced: FloatArray,
    right: FloatArray,
) -> int:
    """Rows and columns [N, with sliding friction; those that stick] of the operator; returns how many stick.

    mode, tangent_of (>= n_contacts,): what each contact does, and its tangential row. sliding, sticking: whether these
    modes count; without, a contact is as if frictionless. Out: stick, reduced, right (the free velocity).
    """
    n = data.n_contacts
    G = data.delassus
    n_stick = 0
    if sticking:
        for k in range(n):
            if mode[k] == STICKING:
                stick[n_stick] = k
                n_stick += 1
    for r in range(n + n_stick):
        i = r if r < n else n + tangent_of[stick[r - n]]
        right[r] = data.free[i]
        for k in range(n):
            value = G[i, k]
            sign = sliding_sign(mode[k])
            if sliding and sign != 0.0:
                value -= sign * data.friction[k] * G[i, n + tangent_of[k]]
            reduced[r, k] = value
        for j in range(n_stick):
            reduced[r, n + j] = G[i, n + tangent_of[stick[j]]]
    return n_stick
