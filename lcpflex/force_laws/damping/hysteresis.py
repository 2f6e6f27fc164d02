"""Hysteresis damping: a force that grows with the elastic one, by a factor chosen for a coefficient of restitution."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from lcpflex.basics.options import keep_number
from lcpflex.errors import ModelError, shown
from lcpflex.force_laws.arguments import numbers_of
from lcpflex.force_laws.damping.rebound import exact_factor, rebound_of_factor
from lcpflex.force_laws.layout import ElasticLaw
from lcpflex.jit.kernel import FloatArray

__all__ = ["HysteresisDamping", "HysteresisFactor", "check_linear", "fractions"]


class HysteresisFactor(Enum):
    """Factor eta(e) of the force F(delta) (1 + eta v / v_0), as in the literature.

    In the usual form, K delta^n + chi delta^n v, chi = eta K / v_0. Two free bodies part with the restitution e_out
    that solves ln((1 + eta) / (1 - e_out eta)) = eta (1 + e_out), which is the prescribed e for EXACT only:

    =========================  ==============================  ==============================================
    member                     eta(e)                          e_out for e = .1, .3, .5, .7, .9, .99
    =========================  ==============================  ==============================================
    EXACT                      root of the equation above      .1000 .3000 .5000 .7000 .9000 .9900
    HUNT_CROSSLEY              3(1-e)/2                        .5158 .5813 .6630 .7680 .9090 .9901
    HERBERT_MCWHANNELL         6(1-e)/((2e-1)^2+3)             .4907 .5200 .5936 .7227 .9009 .9900
    LEE_WANG                   3(1-e)/4                        .6867 .7390 .7992 .8693 .9524 .9950
    LANKARANI_NIKRAVESH        3(1-e^2)/4                      .6653 .6842 .7252 .7960 .9132 .9901
    GONTHIER                   (1-e^2)/e                       .1010 .3042 .4877 .6696 .8764 .9868
    ZHIYING_QISHAO             (3/4)(1-e^2) exp(2(1-e))        .2175 .3267 .4826 .6796 .8959 .9900
    FLORES                     8(1-e)/(5e)                     .0694 .2562 .4704 .6832 .8939 .9893
    GHARIB_HURMUZLU            1/e                             .1000 .2819 .4107 .5008 .5668 .5911
    HU_GUO                     3(1-e)/(2e)                     .0741 .2707 .4877 .6973 .8999 .9900
    CARVALHO_MARTINS           (3/2)(1-e)(11-e)/(1+9e)         .1289 .3040 .5002 .7000 .9000 .9900
    SAFAEIFAR_FARSHIDIANFAR    5(1-e)/(4e)                     .0889 .3138 .5362 .7350 .9152 .9917
    ZHANG                      3(1-e)/(2 e^0.89)               .0954 .3017 .5081 .7057 .9009 .9900
    YE                         3(1-e)/(2e), linear springs     .0741 .2707 .4877 .6973 .8999 .9900
    PANT                       3(1-e^2)/(2e^2), linear springs  .0067 .0659 .2171 .4770 .8093 .9801
    =========================  ==============================  ==============================================

    The formulas of GHARIB_HURMUZLU (the limit of the exact one for e -> 0; it loses energy even at e = 1),
    CARVALHO_MARTINS, SAFAEIFAR_FARSHIDIANFAR and ZHANG are unconfirmed: not checked against their papers.
    GONTHIER is the approximation eta = d/e with d = 1 - e^2; the equation of Gonthier's paper itself is EXACT, as those
    of Marhefka & Orin 1999 and of Zhang & Sharf 2009. HUNT_CROSSLEY, HERBERT_MCWHANNELL, LEE_WANG and
    LANKARANI_NIKRAVESH stay finite at e = 0 and cannot give a low restitution.

    LEE_WANG is what the literature since then calls so. Their paper of 1983 itself has a transition function, by which
    the damping grows over a zone of the penetration; it was found in no public source, and is not here. The function
    :func:`lcpflex.laws.impact_function` has such a zone, with the cubic of the programs that it is known from.
    """

    EXACT = "exact"
    HUNT_CROSSLEY = "Hunt & Crossley 1975"
    HERBERT_MCWHANNELL = "Herbert & McWhannell 1977"
    LEE_WANG = "Lee & Wang 1983"
    LANKARANI_NIKRAVESH = "Lankarani & Nikravesh 1990"
    GONTHIER = "Gonthier et al. 2004, approximation"
    ZHIYING_QISHAO = "Zhiying & Qishao 2006"
    FLORES = "Flores et al. 2011"
    GHARIB_HURMUZLU = "Gharib & Hurmuzlu 2012"
    HU_GUO = "Hu & Guo 2015"
    CARVALHO_MARTINS = "Carvalho & Martins 2019"
    SAFAEIFAR_FARSHIDIANFAR = "Safaeifar & Farshidianfar 2020"
    ZHANG = "Zhang et al. 2020"
    YE = "Ye et al. 2009"
    PANT = "Pant & Wijeyewickrema 2012"

    @property
    def linear(self) -> bool:
        """Whether it was given for linear springs, and goes with no others."""
        return self in (HysteresisFactor.YE, HysteresisFactor.PANT)

    @property
    def needs_rebound(self) -> bool:
        """Whether it grows without bound for e -> 0."""
        return self not in FINITE

    def eta(self, restitution: ArrayLike) -> Any:
        """The factor for a prescribed coefficient of restitution e in [0, 1], a number or an array.

        Raises
        ------
        ModelError
            For e outside [0, 1], and for e = 0 where the factor is infinite there.
        """
        e = fractions(restitution, zero=True)
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            endless = self.needs_rebound & (e < LEAST)
            factor = FACTORS[self](np.where(endless, 1.0, e))
        endless |= ~np.isfinite(factor)
        if np.any(endless):
            raise ModelError(f"restitution: {e[endless][0]} was given, expected e > 0 for {self}: eta is infinite at 0")
        return float(factor) if e.ndim == 0 else factor

    def rebound(self, restitution: ArrayLike) -> Any:
        """e_out of two free bodies for a prescribed coefficient of restitution, a number or an array."""
        return rebound_of_factor(self.eta(restitution))


FACTORS: dict[HysteresisFactor, Callable[[Any], Any]] = {
    HysteresisFactor.EXACT: exact_factor,
    HysteresisFactor.HUNT_CROSSLEY: lambda e: 1.5 * (1.0 - e),
    HysteresisFactor.HERBERT_MCWHANNELL: lambda e: 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0),
    HysteresisFactor.LEE_WANG: lambda e: 0.75 * (1.0 - e),
    HysteresisFactor.LANKARANI_NIKRAVESH: lambda e: 0.75 * (1.0 - e**2),
    HysteresisFactor.GONTHIER: lambda e: (1.0 - e**2) / e,
    HysteresisFactor.ZHIYING_QISHAO: lambda e: 0.75 * (1.0 - e**2) * np.exp(2.0 * (1.0 - e)),
    HysteresisFactor.FLORES: lambda e: 1.6 * (1.0 - e) / e,
    HysteresisFactor.GHARIB_HURMUZLU: lambda e: 1.0 / e,
    HysteresisFactor.HU_GUO: lambda e: 1.5 * (1.0 - e) / e,
    HysteresisFactor.CARVALHO_MARTINS: lambda e: 1.5 * (1.0 - e) * (11.0 - e) / (1.0 + 9.0 * e),
    HysteresisFactor.SAFAEIFAR_FARSHIDIANFAR: lambda e: 1.25 * (1.0 - e) / e,
    HysteresisFactor.ZHANG: lambda e: 1.5 * (1.0 - e) / e**0.89,
    HysteresisFactor.YE: lambda e: 1.5 * (1.0 - e) / e,
    HysteresisFactor.PANT: lambda e: 1.5 * (1.0 - e**2) / e**2,
}
LEAST = 1e-300  # restitution: the inverse of a smaller one has no number, or soon has none
FINITE = (
    HysteresisFactor.HUNT_CROSSLEY,
    HysteresisFactor.HERBERT_MCWHANNELL,
    HysteresisFactor.LEE_WANG,
    HysteresisFactor.LANKARANI_NIKRAVESH,
    HysteresisFactor.ZHIYING_QISHAO,
    HysteresisFactor.CARVALHO_MARTINS,
)


def fractions(restitution: ArrayLike, *, zero: bool) -> FloatArray:
    """Restitution as an array if all of it is in [0, 1], or in (0, 1] and no smaller than its inverse has a number."""
    e = numbers_of("restitution", restitution)
    wrong = e[~((e <= 1.0) & ((e >= 0.0) if zero else (e >= LEAST)))]
    if wrong.size > 0:
        expected = "[0, 1]" if zero else f"(0, 1], and not below {LEAST:g}"
        raise ModelError(f"restitution: {wrong[0]} was given, expected a number in {expected}")
    return e


def check_linear(name: str, elastic: ElasticLaw) -> None:
    """Raise ModelError unless ``elastic`` is a linear spring."""
    if elastic.kind != "power" or elastic.parameters[1] != 1.0:
        raise ModelError(
            f"damping: {name} was given with {shown(elastic)}, expected a linear spring, PowerLaw(K, exponent=1)"
        )


@dataclass(frozen=True, slots=True)
class HysteresisDamping:
    """F(delta) (1 + eta v / max(v_0, v_guard)) with the rate v of the indentation and the impact speed v_0.

    Of any elastic law F. The force is zero at touch without a jump; in a free impact it is never negative. It would be
    where bodies are pulled apart faster than v_0/eta: there it is zero. Two free bodies part with
    e_out = ``factor.rebound(restitution)``, which is the restitution itself for EXACT; other loads during the impact
    change that. Source: Hunt & Crossley 1975, and that of the factor.

    Attributes
    ----------
    restitution
        Prescribed e in [0, 1]; > 0 for factors that are infinite at 0.
    factor
        How eta follows from it.
    guard_speed
        v_guard > 0 [m/s] stands for impact speeds below it. Damping goes as 1/v_0: what touches ever so slowly would be
        overdamped without bound, as a stack at rest. Impacts slower than this rebound higher than prescribed; those
        faster are not changed, and a body that comes to rest keeps the damping of its last impact.

    Raises
    ------
    ModelError
        For a number out of its range; YE and PANT with anything but a linear spring (when the law is put together).
    """

    kind: ClassVar[str] = "hysteresis"
    remembers: ClassVar[bool] = True  # the impact speed
    restitution: float
    factor: HysteresisFactor = HysteresisFactor.EXACT
    guard_speed: float = 1e-4

    def __post_init__(self) -> None:
        if not isinstance(self.factor, HysteresisFactor):
            raise ModelError(f"factor: {shown(self.factor)} was given, expected a HysteresisFactor such as EXACT")
        keep_number(self, "restitution", 0.0, 1.0)
        keep_number(self, "guard_speed", 0.0, math.inf, open_ends=True)
        self.factor.eta(self.restitution)

    @property
    def eta(self) -> float:
        """Factor of v / v_0."""
        return float(self.factor.eta(self.restitution))

    @property
    def parameters(self) -> tuple[float, ...]:
        """eta."""
        return (self.eta,)

    def check(self, elastic: ElasticLaw) -> None:
        """Raise ModelError for a factor of linear springs with another elastic law."""
        if self.factor.linear:
            check_linear(f"the factor {self.factor.name}", elastic)
