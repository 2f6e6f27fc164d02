"""Two parallel cylinders that touch along a line: a pin in a hole, or side by side."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass

from lcpflex.errors import ModelError, ModelWarning, in_range
from lcpflex.force_laws.elastic.materials import Material, check_materials, check_units, contact_modulus
from lcpflex.force_laws.elastic.round_surfaces import Shaped, radii_between

__all__ = ["CylinderPair"]

LONG = 100.0  # length over the larger radius: no roller and no hinge is longer
CONFORMING = 0.3  # largest half-width of a contact over the smaller radius for the theory of half-spaces


@dataclass(frozen=True, slots=True)
class CylinderPair:
    """Two parallel cylinders in contact along a line; made by :meth:`internal` and :meth:`external`.

    Attributes
    ----------
    first_radius
        R_i > 0 [m]: of the hole, or of either cylinder.
    second_radius
        R_j > 0 [m]: of the pin, or of the other cylinder.
    length
        L > 0 [m] of the line of contact.
    material
        Of the first body.
    other
        Of the second body; None: the same.
    is_internal
        Whether the second cylinder lies in the first.

    Raises
    ------
    ModelError
        For radii and lengths that are not positive, what is no Material, and a pin that is not smaller than its hole.
    """

    first_radius: float
    second_radius: float
    length: float
    material: Material
    other: Material | None
    is_internal: bool

    def __post_init__(self) -> None:
        names = ("hole_radius", "pin_radius") if self.is_internal else ("radius", "other_radius")
        for field, name in (("first_radius", names[0]), ("second_radius", names[1]), ("length", "length")):
            object.__setattr__(self, field, in_range(name, getattr(self, field), 0.0, math.inf, open_ends=True))
        check_materials(self.material, self.other)
        if self.is_internal and not self.second_radius < self.first_radius:
            expected = f"expected less than hole_radius, {self.first_radius:g} m"
            raise ModelError(f"pin_radius: {self.second_radius:g} m was given, {expected}")

    @classmethod
    def internal(
        cls, hole_radius: float, pin_radius: float, length: float, material: Material, other: Material | None = None
    ) -> CylinderPair:
        """A pin in a hole that is larger. ``material`` is that of the hole, ``other`` that of the pin if another.

        hole_radius, pin_radius, length: of the hole, the pin and their contact [m].
        """
        return cls(hole_radius, pin_radius, length, material, other, is_internal=True)

    @classmethod
    def external(
        cls, radius: float, other_radius: float, length: float, material: Material, other: Material | None = None
    ) -> CylinderPair:
        """Two cylinders side by side. ``other`` is the material of the second if another.

        radius, other_radius, length: of the cylinders and their contact [m].
        """
        return cls(radius, other_radius, length, material, other, is_internal=False)

    @classmethod
    def between(
        cls, a: Shaped, b: Shaped, length: float, material: Material, other: Material | None = None
    ) -> CylinderPair:
        """The pair of two surfaces of a scene, with their radii: a disc in a hole, or two discs or round parts.

        ``material`` is that of the body of a, ``other`` that of the body of b if another; which of them has the hole
        does not matter.

        length: of the contact [m].

        Raises
        ------
        ModelError
            For surfaces without a radius, a disc that does not fit its hole, and half-planes: no law of two cylinders
            has a limit for DeltaR -> infinity.
        """
        check_materials(material, other)
        first, second = radii_between(a, b)
        if math.inf in (first, second):
            argument, plane = ("a", a) if first == math.inf else ("b", b)
            raise ModelError(
                f"{argument}: {plane.label!r} (a half-plane) was given, expected a round surface: how far a cylinder "
                "indents a plane depends on the size of its body; state a radius by CylinderPair.external(...), or a "
                "law by PowerLaw(...)"
            )
        if first < 0.0:
            return cls.internal(-first, second, length, material, other)
        if second < 0.0:
            return cls.internal(-second, first, length, material if other is None else other, other and material)
        return cls.external(first, second, length, material, other)

    @property
    def clearance(self) -> float:
        """DeltaR [m]: R_i - R_j of a pin in a hole, R_i + R_j of cylinders side by side."""
        return self.first_radius + (-self.second_radius if self.is_internal else self.second_radius)

    @property
    def effective_radius(self) -> float:
        """R = R_i R_j / DeltaR [m]."""
        return self.first_radius * self.second_radius / self.clearance

    @property
    def contact_modulus(self) -> float:
        """E* [Pa]: 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j."""
        return contact_modulus(self.material, self.other)

    @property
    def range_of_force(self) -> float:
        """Force [N] at which the half-width b = sqrt(4 F R / (pi E* L)) of the contact is 0.3 of the smaller radius."""
        width = CONFORMING * min(self.first_radius, self.second_radius)
        return width**2 * math.pi * self.contact_modulus * self.length / (4.0 * self.effective_radius)

    def check(self, lenient: bool) -> None:
        """Moduli in Pa, radii and length in m, as far as can be told.

        lenient: whether units that look like N and mm pass.
        """
        radii = (self.first_radius, self.second_radius)
        check_units((self.material, self.other), radii, lenient, stacklevel=6)
        if self.length > LONG * max(radii) and self.length >= 1.0:
            text = f"length: {self.length:g} m was given, which looks like mm beside radii of at most {max(radii):g} m"
            warnings.warn(text, ModelWarning, stacklevel=5)
