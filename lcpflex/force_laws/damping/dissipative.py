"""Dissipative laws of contact that are no hysteresis damping.

Written for two bodies of effective mass m = 1/G_NN = 1/(1/m_1 + 1/m_2), with delta > 0 the indentation and v its rate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from lcpflex.basics.options import keep_number, keep_number_or_none
from lcpflex.errors import ModelError
from lcpflex.force_laws.arguments import finite_numbers
from lcpflex.force_laws.damping.hysteresis import check_linear, fractions
from lcpflex.force_laws.damping.rebound import damping_ratio, half_oscillation, rebound_of_drag, rebound_of_ratio
from lcpflex.force_laws.layout import ElasticLaw

__all__ = ["Jankowski", "KelvinVoigt", "KuwabaraKono", "PermanentIndentation", "Ristow", "Tsuji"]


STRONGEST = 1e6  # A' or g': e_out is below 1e-10


def strengths(values: ArrayLike) -> Any:
    """Values as an array if they are finite, not negative, and leave a rebound that can be told from rounding."""
    given = finite_numbers("parameter", values, 0.0)
    if given.size and given.max() > STRONGEST:
        raise ModelError(f"parameter: {given.max():g} was given, expected numbers in [0, {STRONGEST:g}]")
    return given


class Speedless:
    """Damping that divides by no speed; with any elastic law where it does not say otherwise."""

    __slots__ = ()
    guard_speed: ClassVar[float] = 0.0

    def check(self, elastic: ElasticLaw) -> None:
        """Goes with any elastic law."""


@dataclass(frozen=True, slots=True)
class Oscillator(Speedless):
    """Damping that makes a linear oscillator of the damping ratio zeta of a contact, by a prescribed restitution."""

    restitution: float
    mass: float | None = None

    def __post_init__(self) -> None:
        keep_number(self, "restitution", 0.0, 1.0)
        keep_number_or_none(self, "mass", 0.0, math.inf, open_ends=True)

    @property
    def parameters(self) -> tuple[float, ...]:
        """zeta; mass, or zero."""
        return float(damping_ratio(self.restitution)), self.mass or 0.0

    @property
    def remembers(self) -> bool:
        """Whether it needs the mass of the contact."""
        return self.mass is None

    @staticmethod
    def rebound(restitution: ArrayLike) -> Any:
        """e_out of two free bodies for a prescribed coefficient of restitution in [0, 1], a number or an array."""
        return rebound_of_ratio(damping_ratio(fractions(restitution, zero=True)))


@dataclass(frozen=True, slots=True)
class KelvinVoigt(Oscillator):
    """Spring and dashpot, K delta + c v with c = 2 zeta (K m)^(1/2), zeta = -ln e / (pi^2 + ln^2 e)^(1/2).

    Of linear springs only. It jumps to c v_0 at touch, and would pull before the indentation is zero, where the force
    is zero instead. The prescribed e is that of a contact that may pull; without pulling two free bodies part with
    e_out = exp(-(2 zeta / q) atan(q / zeta)), q = (1 - zeta^2)^(1/2):

        e      .1     .3     .5     .7     .9
        e_out  .2527  .3971  .5503  .7182  .9020

    and no less than e^-2 = .1353, at e = 0. ``prescribed_restitution(KelvinVoigt, e_out)`` is the e to give.
    Sources: Dubowsky & Freudenstein 1971, Anagnostopoulos 1988.

    The law of Khulief & Shabana 1987, of this form with constants from a balance of momentum and energy, is not here:
    its formula was found in no public source, and a guess would bear their name. Such a balance over two undamped
    half-cycles, with v_0 and e v_0, gives c = (2/pi) (1 - e) (K m)^(1/2), zeta = (1 - e)/pi, to which zeta above tends
    for e -> 1: it is 5 % below that at e = 0.9, 26 % at 0.5.

    Attributes
    ----------
    restitution
        Prescribed e in [0, 1].
    mass
        m [kg] in c; None: that of the contact, 1/G_NN when it begins.

    Raises
    ------
    ModelError
        For a number out of its range; with an elastic law that is no linear spring (when the law is put together).
    """

    kind: ClassVar[str] = "viscous"
    remembers: ClassVar[bool] = True  # it jumps at touch, where a step is to end, and may need the mass

    def check(self, elastic: ElasticLaw) -> None:
        """Raise ModelError unless ``elastic`` is a linear spring."""
        check_linear("KelvinVoigt", elastic)


@dataclass(frozen=True, slots=True)
class Tsuji(Oscillator):
    """F(delta) + alpha (m K)^(1/2) delta^((n-1)/2) v for F = K delta^n, alpha = (2 (n+1))^(1/2) zeta.

    zeta as for :class:`KelvinVoigt`, of which this is the counterpart for n other than 1: in the plane of
    s = (2 E(delta) / m)^(1/2) and v both are one linear oscillator. For elastic laws that are no power that is taken as
    the law, 2 zeta (m / (2 E))^(1/2) F v with the stored energy E. Zero at touch without a jump for n > 1. It would
    pull before the indentation is zero, where the force is zero instead: e_out is that of :class:`KelvinVoigt`, for any
    elastic law, mass and speed. Source: Tsuji, Tanaka & Ishida 1992 (n = 3/2).

    Attributes
    ----------
    restitution
        Prescribed e in [0, 1]; ``prescribed_restitution(Tsuji, e_out)`` is the one to give.
    mass
        m [kg]; None: that of the contact, 1/G_NN when it begins.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    kind: ClassVar[str] = "tsuji"


@dataclass(frozen=True, slots=True)
class KuwabaraKono(Speedless):
    """F(delta) + A F'(delta) v: a viscoelastic material, K (delta^(3/2) + (3/2) A delta^(1/2) v) in Hertz's contact.

    Zero at touch without a jump wherever F'(0) = 0. It would pull before the indentation is zero, where the force is
    zero instead. In Hertz's point contact e_out of two free bodies depends on A' = A (K/m)^(2/5) v_0^(1/5) only, and
    falls with the impact speed: e_out = 1 - 1.7301733 A' + ...; ``restitution_of(KuwabaraKono, A')`` gives it.
    Sources: Kuwabara & Kono 1987, Brilliantov et al. 1996.

    Attributes
    ----------
    relaxation
        A >= 0 [s].

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    kind: ClassVar[str] = "kuwabara_kono"
    remembers: ClassVar[bool] = False  # nothing from the touch
    relaxation: float

    def __post_init__(self) -> None:
        keep_number(self, "relaxation", 0.0, math.inf)

    @property
    def parameters(self) -> tuple[float, ...]:
        """A."""
        return (self.relaxation,)

    @staticmethod
    def rebound(parameter: ArrayLike) -> Any:
        """e_out of two free bodies in Hertz's point contact for A' = A (K/m)^(2/5) v_0^(1/5), a number or an array.

        parameter: A' >= 0 [-].
        """
        return rebound_of_drag(1.5 * 0.8**0.4 * strengths(parameter), 0.2)


@dataclass(frozen=True, slots=True)
class Ristow(Speedless):
    """F(delta) + gamma m v: the simplest damping beside Hertz's force, constant.

    It jumps to gamma m v_0 at touch, and would pull before the indentation is zero, where the force is zero instead.
    In Hertz's point contact e_out of two free bodies depends on g' = gamma (m/K)^(2/5) v_0^(-1/5) only, and grows with
    the impact speed: e_out = 1 - 1.7878141 g' + ...; ``restitution_of(Ristow, g')`` gives it. Without the clip bodies
    would not part at all from g' = 1.5 on. Sources: Ristow 1992, Lee & Herrmann 1993.

    Attributes
    ----------
    rate
        gamma >= 0 [1/s].
    mass
        m [kg]; None: that of the contact, 1/G_NN when it begins.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    kind: ClassVar[str] = "ristow"
    remembers: ClassVar[bool] = True  # it jumps at touch, where a step is to end, and may need the mass
    rate: float
    mass: float | None = None

    def __post_init__(self) -> None:
        keep_number(self, "rate", 0.0, math.inf)
        keep_number_or_none(self, "mass", 0.0, math.inf, open_ends=True)

    @property
    def parameters(self) -> tuple[float, ...]:
        """gamma; mass, or zero."""
        return self.rate, self.mass or 0.0

    @staticmethod
    def rebound(parameter: ArrayLike) -> Any:
        """e_out of two free bodies in Hertz's point contact for g' = gamma (m/K)^(2/5) v_0^(-1/5).

        parameter: g' >= 0 [-].
        """
        return rebound_of_drag(0.8**0.6 * strengths(parameter), -0.2)


@dataclass(frozen=True, slots=True)
class Jankowski(Oscillator):
    """K delta^(3/2) + c v on the way in, K delta^(3/2) on the way out, with c = 2 xi (m K)^(1/2) delta^(1/4).

        xi = (9 5^(1/2) / 2) (1 - e^2) / (e (e (9 pi - 16) + 16))

    No jump at touch and no attraction; the force drops to the elastic one where the contact turns back, with no jump as
    v is zero there. |e_out - e| <= 0.009 for two free bodies. The formula is unconfirmed: it has not been checked
    against the paper. With other elastic laws F the damping is that of :class:`Tsuji` with zeta = 2 xi / 5^(1/2), which
    is the same for n = 3/2, and e_out is the same. Source: Jankowski 2005.

    Attributes
    ----------
    restitution
        Prescribed e in (0, 1]; xi is infinite at 0.
    mass
        m [kg]; None: that of the contact, 1/G_NN when it begins.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    kind: ClassVar[str] = "jankowski"

    def __post_init__(self) -> None:
        Oscillator.__post_init__(self)
        fractions(self.restitution, zero=False)

    @property
    def parameters(self) -> tuple[float, ...]:
        """zeta; mass, or zero."""
        return float(jankowski_ratio(self.restitution)), self.mass or 0.0

    @staticmethod
    def rebound(restitution: ArrayLike) -> Any:
        """e_out of two free bodies for a prescribed coefficient of restitution in (0, 1], a number or an array."""
        return half_oscillation(jankowski_ratio(fractions(restitution, zero=False)))


def jankowski_ratio(e: Any) -> Any:
    """zeta = 2 xi / 5^(1/2)."""
    return 9.0 * (1.0 - e * e) / (e * (e * (9.0 * math.pi - 16.0) + 16.0))


@dataclass(frozen=True, slots=True)
class PermanentIndentation(Speedless):
    """Loading F(delta), unloading F((delta - delta_p) / e^2) from the largest indentation delta_m.

    delta_p = (1 - e^2) delta_m stays; for F = K delta^n unloading is F_m ((delta - delta_p) / (delta_m - delta_p))^n.
    Quasi-static: nothing depends on speed, a contact that is loaded again goes up the unloading curve, and beyond
    delta_m on the loading one. No jump and no attraction; the force is zero below delta_p. Two free bodies part with
    e_out = e exactly, for any elastic law, mass and speed. The indentation is forgotten when the gap opens: the next
    impact finds surfaces as new. Source: Lankarani & Nikravesh 1994.

    Attributes
    ----------
    restitution
        e in (0, 1]; at 0 the unloading would be infinitely steep.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    kind: ClassVar[str] = "permanent"
    remembers: ClassVar[bool] = True  # the largest indentation
    restitution: float

    def __post_init__(self) -> None:
        keep_number(self, "restitution", 0.0, 1.0)
        fractions(self.restitution, zero=False)

    @property
    def parameters(self) -> tuple[float, ...]:
        """e."""
        return (self.restitution,)

    @staticmethod
    def rebound(restitution: ArrayLike) -> Any:
        """e_out = e, a number or an array.

        restitution: prescribed, in [0, 1].
        """
        e = fractions(restitution, zero=False)
        return e if e.ndim else float(e)
