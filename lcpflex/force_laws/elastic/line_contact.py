"""Line contact of parallel cylinders: the logarithmic laws.

All have one form, delta(F) = (F/a) [ln(c/F) + d]. With C = c e^d and u = ln(C/F) > 1

    F = a delta / u,   dF/ddelta = a / (u - 1),   energy = a (delta/u)^2 (u/2 - 1/4),
    u - ln u = ln(C / (a delta)), by Newton's method

They end in a fold, at delta_fold = C / (a e) and F = C / e, where the stiffness is infinite. E* is the modulus of the
contact, L its length, DeltaR the difference of the radii of a pin in a hole, the sum for cylinders side by side, and
R = R_i R_j / DeltaR. For two materials the E* form is exact only where both bodies have the same (1 - nu^2)/E.
Plane elasticity has no absolute approach of two bodies: the laws differ by the remote points that they measure from.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from lcpflex.basics.options import keep_flag, keep_number
from lcpflex.errors import ModelError, ModelWarning, shown
from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
from lcpflex.force_laws.elastic.kernels import LAST_LOGARITHM
from lcpflex.force_laws.elastic.law import ElasticFace

__all__ = [
    "DubowskyFreudenstein",
    "Esdu78035",
    "Goldsmith",
    "Johnson",
    "Logarithmic",
    "OfPair",
    "Radzimovsky",
    "check_pair",
]


def check_pair(law: Any) -> None:
    """A law of a CylinderPair in SI units, and whether it is lenient."""
    keep_flag(law, "lenient")
    if not isinstance(law.pair, CylinderPair):
        expected = "expected a CylinderPair, such as CylinderPair.internal(...)"
        raise ModelError(f"pair: {shown(law.pair)} was given, {expected}")
    law.pair.check(law.lenient)


@dataclass(frozen=True, slots=True)
class OfPair(ElasticFace):
    """A law of two parallel cylinders."""

    pair: CylinderPair
    lenient: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        check_pair(self)


class Logarithmic(OfPair):
    """What the logarithmic laws share; each of them has its own constants a [N/m], c [N] and d."""

    __slots__ = ()
    kind: ClassVar[str] = "logarithmic"

    if TYPE_CHECKING:

        @property
        def constants(self) -> tuple[float, float, float]:
            """a [N/m], c [N], d."""

    @property
    def parameters(self) -> tuple[float, ...]:
        """a, C, ln(C/a)."""
        a, c, d = self.constants
        return a, c * math.exp(d), math.log(c / a) + d

    @property
    def fold(self) -> float:
        """delta_fold = C / (a e) [m]."""
        a, C, _ = self.parameters
        return C / (a * math.e)

    @property
    def end(self) -> float:
        """Indentation just before the fold, 0.99995 delta_fold, where the stiffness is still finite, 100 a [m]."""
        return self.fold * LAST_LOGARITHM * math.exp(1.0 - LAST_LOGARITHM)

    @property
    def limit(self) -> float:
        """Indentation [m] at which the half-width b = sqrt(4 F R / (pi E* L)) of the contact is 0.3 of the smaller
        radius, or :attr:`end`. Below a tenth of the fold the laws are at their best."""
        a, C, _ = self.parameters
        u = math.log(C / self.pair.range_of_force)
        return self.pair.range_of_force / a * u if u > LAST_LOGARITHM else self.end


@dataclass(frozen=True, slots=True)
class Johnson(Logarithmic):
    """Johnson's law of cylinders: a = pi E* L, c = 4 pi E* DeltaR L, d = -1.

    It is the sum of delta_k = f (1 - nu_k^2)/(pi E_k) [2 ln(4 R_k / b) - 1] of both bodies, with f = F/L and the
    half-width b, where both have the same constants. The fold lies at 0.541 DeltaR.
    Source: Johnson, Contact Mechanics, 1985.

    Attributes
    ----------
    pair
        The two cylinders.
    lenient
        Whether an indentation beyond ``limit`` (half-width above 0.3 of the smaller radius) is a warning instead of an
        error.

    Raises
    ------
    ModelError
        For what is no CylinderPair, and numbers that look like N and mm (unless lenient).
    """

    @property
    def constants(self) -> tuple[float, float, float]:
        """a [N/m], c [N], d."""
        a = math.pi * self.pair.contact_modulus * self.pair.length
        return a, 4.0 * a * self.pair.clearance, -1.0


@dataclass(frozen=True, slots=True)
class Radzimovsky(Logarithmic):
    """Radzimovsky's law of cylinders: a = pi E* L, d = 2/3, c = 6.25 E* DeltaR L, with ``handbook`` 3.125 E* DeltaR L.

    The first is the form of the literature on multibody systems, delta = f/(pi E*) [2/3 + ln(4 R_i/b) + ln(4 R_j/b)]
    with b = 1.60 sqrt(f R / E*), f = F/L; the second that of handbooks, with the diameters over the full width in the
    logarithms, which is unconfirmed.

    Attributes
    ----------
    pair
        The two cylinders.
    handbook
        Whether the form of handbooks is meant.
    lenient
        Whether an indentation beyond ``limit`` (half-width above 0.3 of the smaller radius) is a warning instead of an
        error.

    Raises
    ------
    ModelError
        For what is no CylinderPair, and numbers that look like N and mm (unless lenient).
    """

    handbook: bool = False

    def __post_init__(self) -> None:
        check_pair(self)
        keep_flag(self, "handbook")

    @property
    def constants(self) -> tuple[float, float, float]:
        """a [N/m], c [N], d."""
        scale = self.pair.contact_modulus * self.pair.length
        factor = 3.125 if self.handbook else 6.25
        return math.pi * scale, factor * scale * self.pair.clearance, 2.0 / 3.0


@dataclass(frozen=True, slots=True)
class Goldsmith(Logarithmic):
    """Goldsmith's law of cylinders: delta = (F h/L) [ln(L^m / (F R h)) + 1], h = 1/(pi E*).

    The literature has m = 1, with which the logarithm is of a number with units: this library takes that number in SI
    units, and other units give another law. Only m = 3 is sound, which is :class:`DubowskyFreudenstein`.

    Attributes
    ----------
    pair
        The two cylinders.
    m
        Exponent of the length, in [1, 4].
    lenient
        Whether an indentation beyond ``limit`` (half-width above 0.3 of the smaller radius, or the fold, at L^(m-1)/R)
        is a warning instead of an error.

    Raises
    ------
    ModelError
        For what is no CylinderPair, m out of range, and numbers that look like N and mm (unless lenient).
    """

    m: float = field(default=1.0, kw_only=True)

    def __post_init__(self) -> None:
        check_pair(self)
        keep_number(self, "m", 1.0, 4.0)

    @property
    def constants(self) -> tuple[float, float, float]:
        """a [N/m], c [N], d."""
        stiff = math.pi * self.pair.contact_modulus
        return stiff * self.pair.length, stiff * self.pair.length**self.m / self.pair.effective_radius, 1.0


@dataclass(frozen=True, slots=True)
class DubowskyFreudenstein(Logarithmic):
    """Dubowsky and Freudenstein's law: delta = (F h/L) [ln(L^3 DeltaR / (F R_i R_j h)) + 1], h = 1/(pi E*).

    Goldsmith's with m = 3. The length stands for the distance of the remote points: the fold lies at L^2/R, before the
    half-width is 0.3 of the smaller radius where the line is short. Source: Dubowsky & Freudenstein 1971.

    Attributes
    ----------
    pair
        The two cylinders.
    lenient
        Whether an indentation beyond ``limit`` (half-width above 0.3 of the smaller radius, or the fold) is a warning
        instead of an error.

    Raises
    ------
    ModelError
        For what is no CylinderPair, and numbers that look like N and mm (unless lenient).
    """

    @property
    def constants(self) -> tuple[float, float, float]:
        """a [N/m], c [N], d."""
        stiff = math.pi * self.pair.contact_modulus
        return stiff * self.pair.length, stiff * self.pair.length**3 / self.pair.effective_radius, 1.0


@dataclass(frozen=True, slots=True)
class Esdu78035(Logarithmic):
    """The law named ESDU-78035 in reviews, of a pin in a hole: delta = (F H/L) [ln(4 L DeltaR / (F H)) + 1].

    H = 1/(pi E*) in the reading "pi", H = 1/E* in the reading "review". The second reproduces the tables of Autiero et
    al. 2022, and is three to five times softer than all other laws; the first is near them. The text of the data item
    itself has not been seen: both readings are unconfirmed.

    Attributes
    ----------
    pair
        A pin in a hole.
    reading
        "pi" or "review".
    lenient
        Whether an indentation beyond ``limit`` (half-width above 0.3 of the smaller radius), and cylinders side by
        side, are a warning instead of an error.

    Raises
    ------
    ModelError
        For what is no CylinderPair, cylinders side by side (unless lenient), another reading, and numbers that look
        like N and mm (unless lenient).
    """

    reading: Literal["pi", "review"] = "pi"

    def __post_init__(self) -> None:
        check_pair(self)
        if not isinstance(self.reading, str) or self.reading not in ("pi", "review"):
            raise ModelError(f'reading: {shown(self.reading)} was given, expected "pi" or "review"')
        if not self.pair.is_internal:
            text = "pair: cylinders side by side were given, expected a pin in a hole, CylinderPair.internal(...)"
            if not self.lenient:
                raise ModelError(f"{text}; lenient=True gives a warning instead")
            warnings.warn(text, ModelWarning, stacklevel=3)

    @property
    def constants(self) -> tuple[float, float, float]:
        """a [N/m], c [N], d."""
        a = (math.pi if self.reading == "pi" else 1.0) * self.pair.contact_modulus * self.pair.length
        return a, 4.0 * a * self.pair.clearance, 1.0
