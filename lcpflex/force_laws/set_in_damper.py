"""The IMPACT function of commercial multibody programs: a spring, and a damper that sets in over a depth."""

from __future__ import annotations

import math
from typing import Any

from lcpflex.errors import in_range
from lcpflex.force_laws.user_law import UserLaw

__all__ = ["impact_function"]


def impact_function(stiffness: float, exponent: float, damping: float, depth: float) -> UserLaw:
    """Spring and damper with a transition: F = max(0, K delta^n + c(delta) deltadot).

        c(delta) = c_max s^2 (3 - 2 s),   s = min(delta / d, 1)

    IMPACT(x, xdot, x1, K, n, c_max, d) of Adams, RecurDyn, MotionSolve and SolidWorks Motion, where delta = x1 - x. The
    damper of a :class:`KelvinVoigt` acts in full from the touch on, and its force jumps there; here it sets in smoothly
    over the depth d. An elastic law and its damping in one, to be given as ``ContactLaw(impact_function(...))``. It
    needs neither the mass nor the speed of the impact; the restitution that comes of it depends on both, and tends for
    n = 1 and d -> 0 to that of a :class:`KelvinVoigt` with c_max = 2 zeta (K m)^(1/2). For n = 1 and a small c_max two
    free bodies of effective mass m, which strike at v_0 and stay within d, delta_m = v_0 (m/K)^(1/2), lose

        2 c_max (K/m)^(1/2) delta_m^2 ((3 pi/16) sigma^2 - (4/15) sigma^3),   sigma = delta_m / d,

    to first order in c_max. Sources: Altair MotionSolve, IMPACT; SolidWorks Motion, IMPACT and STEP (documentation).

    Parameters
    ----------
    stiffness
        K > 0 [N/m^n].
    exponent
        n >= 1.
    damping
        c_max >= 0 [N s/m].
    depth
        d > 0 [m]: the indentation from which on the damper acts in full.

    Returns
    -------
    UserLaw
        Compiled; its ``force(delta, rate)`` gives F.

    Raises
    ------
    ModelError
        For a number out of its range.
    """
    numbers = (
        in_range("stiffness", stiffness, 0.0, math.inf, open_ends=True),
        in_range("exponent", exponent, 1.0, math.inf),
        in_range("damping", damping, 0.0, math.inf),
        in_range("depth", depth, 0.0, math.inf, open_ends=True),
    )
    return UserLaw(_force, numbers)


def _force(indentation: float, rate: float, impact_speed: float, p: Any) -> float:
    """F before it is clipped."""
    s = indentation / p[3] if indentation < p[3] else 1.0  # the quotient with the least of depths has no number
    return float(p[0] * indentation ** p[1] + p[2] * s * s * (3.0 - 2.0 * s) * rate)
