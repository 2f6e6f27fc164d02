"""What restitution comes out of a dissipative law, and what has to be prescribed for it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lcpflex.basics import libs
from lcpflex.errors import ModelError, shown
from lcpflex.force_laws.arguments import numbers_of
from lcpflex.force_laws.damping.dissipative import (
    Jankowski,
    KelvinVoigt,
    KuwabaraKono,
    PermanentIndentation,
    Ristow,
    Tsuji,
)
from lcpflex.force_laws.damping.hysteresis import HysteresisFactor

__all__ = ["DissipativeLaw", "prescribed_restitution", "restitution_of"]

DissipativeLaw = HysteresisFactor | type[KelvinVoigt | Tsuji | KuwabaraKono | Ristow | Jankowski | PermanentIndentation]
CLASSES = (KelvinVoigt, Tsuji, KuwabaraKono, Ristow, Jankowski, PermanentIndentation)
WITH_PARAMETER = (KuwabaraKono, Ristow)
LARGEST = 1e3  # parameter A' or g' up to which it is looked for
LEAST = 1e-100  # e down to which it is looked for, where a law has none at 0
PRECISE = 8.9e-16  # relative: the finest that brentq takes


def restitution_of(law: DissipativeLaw, e: ArrayLike) -> Any:
    """e_out = -v_out / v_0 of two free bodies under a dissipative law with the prescribed restitution ``e``.

    Parameters
    ----------
    law
        A :class:`HysteresisFactor`, or one of the classes KelvinVoigt, Tsuji, Jankowski, PermanentIndentation,
        KuwabaraKono and Ristow. Forces that would pull are zero.
    e
        Prescribed restitution in [0, 1], a number or an array. For KuwabaraKono and Ristow, which have none, the
        number A' = A (K/m)^(2/5) v_0^(1/5) and g' = gamma (m/K)^(2/5) v_0^(-1/5), in Hertz's point contact.

    Raises
    ------
    ModelError
        For a law that is none of these and for numbers out of range.
    """
    check_law(law)
    return law.rebound(e)


def check_law(law: Any) -> None:
    """Raise ModelError for what is no law with a restitution."""
    if not (isinstance(law, HysteresisFactor) or any(law is known for known in CLASSES)):
        names = ", ".join(known.__name__ for known in CLASSES)
        raise ModelError(f"law: {shown(law)} was given, expected a HysteresisFactor or one of the classes {names}")


def prescribed_restitution(law: DissipativeLaw, e_out: ArrayLike) -> Any:
    """What to prescribe for a law to have ``e_out`` come out: the inverse of :func:`restitution_of`.

    Raises
    ------
    ModelError
        For a law that is none of those, and where nothing prescribed gives ``e_out``; the message tells the range.
    """
    lowest, highest, first, last = _reach(law)
    wanted = numbers_of("e_out", e_out)
    wrong = wanted[~((wanted >= lowest) & (wanted <= highest))]
    if wrong.size > 0:
        named = law if isinstance(law, HysteresisFactor) else law.__name__
        raise ModelError(
            f"e_out: {wrong[0]} was given, expected a number in [{lowest:.6g}, {highest:.6g}]: nothing else comes out "
            f"of {named}"
        )
    found = np.array([_inverse(law, value, first, last) for value in wanted.ravel().tolist()], dtype=float)
    return float(found[0]) if wanted.ndim == 0 else found.reshape(wanted.shape)


def _reach(law: DissipativeLaw) -> tuple[float, float, float, float]:
    """Least and largest e_out, and what has to be prescribed for them."""
    check_law(law)
    if law in WITH_PARAMETER:
        first, last = LARGEST, 0.0
    else:
        unbounded = law.needs_rebound if isinstance(law, HysteresisFactor) else law in (Jankowski, PermanentIndentation)
        first, last = (LEAST if unbounded else 0.0), 1.0
    return float(restitution_of(law, first)), float(restitution_of(law, last)), first, last


def _inverse(law: DissipativeLaw, wanted: float, first: float, last: float) -> float:
    """Root of e_out(x) - wanted between ``first`` and ``last``: e_out is monotone in all laws."""
    for end in (first, last):
        if restitution_of(law, end) == wanted:
            return end
    low, high = sorted((first, last))
    # an e of 1e-30 under KelvinVoigt is another e_out than 0: the tolerance is relative alone
    root = libs.brentq(lambda x: restitution_of(law, x) - wanted, low, high, xtol=1e-300, rtol=PRECISE, maxiter=2000)
    return float(root)
