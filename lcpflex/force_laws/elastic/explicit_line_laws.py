"""Line contact of parallel cylinders: laws that give the force of an indentation explicitly."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any, ClassVar, overload

import numpy as np
import numpy.typing as npt

from lcpflex.basics.options import keep_number
from lcpflex.errors import ModelError, ModelWarning, shown
from lcpflex.force_laws.arguments import numbers_of
from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
from lcpflex.force_laws.elastic.line_contact import OfPair, check_pair
from lcpflex.jit.kernel import FloatArray

__all__ = ["LankaraniNikraveshCylinder", "Liu", "Pereira", "Persson"]

LEAST_CLEARANCE, MOST_CLEARANCE = 0.005, 10.0  # [mm] of Pereira's internal contact
CLEARANCE_OF_CHANGE = 0.34954  # [mm] where its exponent passes from one expression to the other
CHECKED_ANGLE, LAST_ANGLE = math.radians(79.0), math.radians(84.0)  # of Persson's solution


@dataclass(frozen=True, slots=True)
class LankaraniNikraveshCylinder(OfPair):
    """F = (4/3) E* sqrt(R) delta^n, R = R_i R_j / DeltaR: Hertz's law of spheres, taken for cylinders.

    It does not depend on the length of the contact, and its units fit only for n = 3/2 (numbers in SI otherwise). For
    a small clearance it is many times too stiff.

    Attributes
    ----------
    pair
        The two cylinders.
    exponent
        n in [1, 1.5].
    lenient
        Whether an indentation beyond ``limit`` is a warning instead of an error.

    Raises
    ------
    ModelError
        For what is no CylinderPair, an exponent out of its range, and numbers that look like N and mm (unless lenient).
    """

    kind: ClassVar[str] = "power"
    exponent: float = 1.5

    def __post_init__(self) -> None:
        check_pair(self)
        keep_number(self, "exponent", 1.0, 1.5)

    @property
    def parameters(self) -> tuple[float, ...]:
        """K, n."""
        return 4.0 / 3.0 * self.pair.contact_modulus * math.sqrt(self.pair.effective_radius), self.exponent

    @property
    def limit(self) -> float:
        """Indentation [m] at which the half-width sqrt(4 F R / (pi E* L)) is 0.3 of the smaller radius."""
        K, n = self.parameters
        return (self.pair.range_of_force / K) ** (1.0 / n)


@dataclass(frozen=True, slots=True)
class Pereira(OfPair):
    """F = (a DeltaR + b) (L E* / DeltaR) delta^n in N, mm and MPa inside; this face is in SI units.

    A pin in a hole: a = 0.965, b = 0.0965, n = Y DeltaR^-0.005, with Y = 1.51 [ln(1000 DeltaR)]^-0.151 for DeltaR below
    0.34954 mm, else Y = 0.0151 DeltaR + 1.151. Cylinders side by side: a = 0.39, b = 0.85, n = 1.094.
    Of a pin in a hole the clearance is in 0.005 ... 10 mm. Only the coefficients were found in sources; how they go
    together was told by Johnson's law, which this reading is near (0.74 to 1.14 of its force up to 3 mm, steel), and
    others are not. The range of loads was not found: no ``limit`` is known. Source: Pereira, Ramalho & Ambrosio 2015.

    Attributes
    ----------
    pair
        The two cylinders.
    lenient
        Whether the clearance of a pin in a hole above 10 mm is a warning instead of an error. Below 0.005 mm it is an
        error always: the exponent grows without bound.

    Raises
    ------
    ModelError
        For what is no CylinderPair, a clearance out of range, and numbers that look like N and mm (unless lenient).
    """

    kind: ClassVar[str] = "power"

    def __post_init__(self) -> None:
        check_pair(self)
        clearance = 1e3 * self.pair.clearance
        rounding = 1e-9  # of the difference of two radii
        if not self.pair.is_internal or LEAST_CLEARANCE - rounding <= clearance <= MOST_CLEARANCE + rounding:
            return
        text = f"pair: a clearance of {clearance:g} mm was given, expected {LEAST_CLEARANCE:g} to {MOST_CLEARANCE:g} mm"
        if not self.lenient or clearance < LEAST_CLEARANCE:
            raise ModelError(text)
        warnings.warn(text, ModelWarning, stacklevel=3)

    @property
    def parameters(self) -> tuple[float, ...]:
        """K [N/m^n], n."""
        clearance = 1e3 * self.pair.clearance
        a, b, n = 0.39, 0.85, 1.094
        if self.pair.is_internal:
            a, b = 0.965, 0.0965
            below = clearance < CLEARANCE_OF_CHANGE
            Y = 1.51 * math.log(1e3 * clearance) ** -0.151 if below else 0.0151 * clearance + 1.151
            n = Y * clearance**-0.005
        length, modulus = 1e3 * self.pair.length, 1e-6 * self.pair.contact_modulus
        return (a * clearance + b) * length * modulus / clearance * 1e3**n, n


@dataclass(frozen=True, slots=True)
class Liu(OfPair):
    """A pin in a hole: F = (pi/2) E* L delta sqrt(delta / (2 (DeltaR + delta))).

    It is (pi/2) E* L delta sin(eps/2), with the semi-angle of the contact from the geometry of rigid circles,
    cos eps = DeltaR / (DeltaR + delta). No range of validity is known. Source: Liu et al. 2007.

    Attributes
    ----------
    pair
        A pin in a hole.
    lenient
        Whether numbers that look like N and mm are a warning instead of an error.

    Raises
    ------
    ModelError
        For what is no CylinderPair, cylinders side by side, and numbers that look like N and mm (unless lenient).
    """

    kind: ClassVar[str] = "liu"

    def __post_init__(self) -> None:
        check_pair(self)
        _check_internal(self.pair)

    @property
    def parameters(self) -> tuple[float, ...]:
        """(pi/2) E* L, DeltaR."""
        return 0.5 * math.pi * self.pair.contact_modulus * self.pair.length, self.pair.clearance


@dataclass(frozen=True, slots=True)
class Persson(OfPair):
    """A pin in a hole of an infinite plate of the same material, by the semi-angle eps of the contact.

        F(eps) = 2 pi E* L DeltaR (B + 1) B / (2 - ln(B + 1) - 2 B^2),   B = tan^2(eps/2)

    ``force_at_angle`` is this solution; it was checked with an integral equation for 11 to 79 degrees, the formula
    itself is unconfirmed. The load is infinite at 84.83 degrees. ``force`` and all that takes an indentation are
    APPROXIMATE: they close it with the geometry of rigid circles, cos eps = DeltaR / (DeltaR + delta), or
    B = delta / (2 DeltaR + delta), which for little indentation is several times too stiff: (pi/2) E* L delta.
    Source: Persson 1964.

    Attributes
    ----------
    pair
        A pin in a hole.
    lenient
        Whether angles beyond 79 degrees (up to 84), and two materials, are a warning instead of an error.

    Raises
    ------
    ModelError
        For what is no CylinderPair, cylinders side by side, two materials (unless lenient), and numbers that look like
        N and mm (unless lenient).
    """

    kind: ClassVar[str] = "persson"

    def __post_init__(self) -> None:
        check_pair(self)
        _check_internal(self.pair)
        if self.pair.other is not None and self.pair.other != self.pair.material:
            text = "pair: two materials were given, expected one"
            if not self.lenient:
                raise ModelError(f"{text}; lenient=True gives a warning instead")
            warnings.warn(text, ModelWarning, stacklevel=3)

    @property
    def parameters(self) -> tuple[float, ...]:
        """2 pi E* L DeltaR, DeltaR."""
        return 2.0 * math.pi * self.pair.contact_modulus * self.pair.length * self.pair.clearance, self.pair.clearance

    @property
    def limit(self) -> float:
        """Indentation [m] at 79 degrees, up to where the solution was checked."""
        return self._indentation_at_angle(CHECKED_ANGLE)

    @property
    def end(self) -> float:
        """Indentation [m] at 84 degrees, just before the load is infinite."""
        return self._indentation_at_angle(LAST_ANGLE)

    @overload
    def force_at_angle(self, eps: float) -> float: ...
    @overload
    def force_at_angle(self, eps: npt.ArrayLike) -> FloatArray: ...
    def force_at_angle(self, eps: Any) -> Any:
        """F [N] at the semi-angle ``eps`` >= 0 of the contact [rad]; a number or an array of any shape."""
        values = numbers_of("eps", eps)
        last = LAST_ANGLE if self.lenient else CHECKED_ANGLE
        wrong = ~((values >= 0.0) & (values <= last))
        if wrong.any():
            raise ModelError(f"eps: {shown(values[wrong].flat[0])} rad was given, expected 0 to {last:.6g} rad")
        if (values > CHECKED_ANGLE).any():
            text = f"eps: {values.max():.6g} rad was given, Persson is checked up to {CHECKED_ANGLE:.6g} rad"
            warnings.warn(text, ModelWarning, stacklevel=2)
        B = np.tan(0.5 * values) ** 2
        force = self.parameters[0] * (B + 1.0) * B / (2.0 - np.log1p(B) - 2.0 * B * B)
        return float(force) if values.ndim == 0 else force

    def _indentation_at_angle(self, eps: float) -> float:
        return self.pair.clearance * (1.0 / math.cos(eps) - 1.0)


def _check_internal(pair: CylinderPair) -> None:
    if not pair.is_internal:
        text = "pair: cylinders side by side were given, expected a pin in a hole, CylinderPair.internal(...)"
        raise ModelError(text)
