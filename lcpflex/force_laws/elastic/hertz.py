"""Hertz's contact of curved bodies in a point."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from lcpflex.basics.options import keep_flag, keep_number
from lcpflex.errors import ModelError, in_range
from lcpflex.force_laws.elastic.law import ElasticFace
from lcpflex.force_laws.elastic.materials import Material, check_materials, check_units, contact_modulus
from lcpflex.force_laws.elastic.round_surfaces import Shaped, radii_between

__all__ = ["Hertz"]

FLAT = 0.3  # largest radius of a contact over that of the smaller body for the theory of half-spaces


@dataclass(frozen=True, slots=True)
class Hertz(ElasticFace):
    """Point contact of elastic bodies: F = (4/3) E* sqrt(R) delta^(3/2), energy (2/5) F delta.

    Made by :meth:`spheres`, :meth:`sphere_on_plane`, :meth:`sphere_in_cup` and :meth:`between`. The radius of the
    contact is a = sqrt(R delta), the largest pressure 3 F / (2 pi a^2). Valid while a <= 0.3 of the smallest radius of
    the bodies (``limit``), and for elastic, frictionless bodies whose waves are faster than the contact.
    Source: Hertz 1881.

    Attributes
    ----------
    effective_radius
        R > 0 [m].
    contact_modulus
        E* > 0 [Pa]: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2.
    smallest_radius
        > 0 [m], of the two bodies.
    lenient
        Whether an indentation beyond ``limit`` is a warning instead of an error.

    Raises
    ------
    ModelError
        For radii and moduli that are not positive, what is no Material, a sphere that does not fit its cup, and numbers
        that look like N and mm (unless lenient).
    """

    kind: ClassVar[str] = "power"
    effective_radius: float
    contact_modulus: float
    smallest_radius: float
    lenient: bool = field(default=False, kw_only=True)

    def __post_init__(self) -> None:
        for name in ("effective_radius", "contact_modulus", "smallest_radius"):
            keep_number(self, name, 0.0, math.inf, open_ends=True)
        keep_flag(self, "lenient")

    @classmethod
    def spheres(
        cls,
        radius: float,
        other_radius: float,
        material: Material,
        other: Material | None = None,
        *,
        lenient: bool = False,
    ) -> Hertz:
        """Two spheres: 1/R = 1/R1 + 1/R2. ``other`` is the material of the second if another.

        radius, other_radius [m]. lenient: whether units that look like N and mm pass.
        """
        R1, R2 = _radius("radius", radius), _radius("other_radius", other_radius)
        return cls._of(R1 * R2 / (R1 + R2), (R1, R2), material, other, lenient)

    @classmethod
    def sphere_on_plane(
        cls, radius: float, material: Material, other: Material | None = None, *, lenient: bool = False
    ) -> Hertz:
        """A sphere on a half-space: R = R1. ``other`` is the material of the half-space if another.

        radius [m]. lenient: whether units that look like N and mm pass.
        """
        R1 = _radius("radius", radius)
        return cls._of(R1, (R1,), material, other, lenient)

    @classmethod
    def sphere_in_cup(
        cls,
        radius: float,
        cup_radius: float,
        material: Material,
        other: Material | None = None,
        *,
        lenient: bool = False,
    ) -> Hertz:
        """A sphere in a larger hollow one: 1/R = 1/R1 - 1/R2. ``other`` is the material of the cup if another.

        radius, cup_radius [m]. lenient: whether units that look like N and mm pass.
        """
        R1, R2 = _radius("radius", radius), _radius("cup_radius", cup_radius)
        if not R1 < R2:
            raise ModelError(f"radius: {R1:g} m was given, expected less than cup_radius, {R2:g} m")
        return cls._of(R1 * R2 / (R2 - R1), (R1, R2), material, other, lenient)

    @classmethod
    def between(
        cls, a: Shaped, b: Shaped, material: Material, other: Material | None = None, *, lenient: bool = False
    ) -> Hertz:
        """Spheres with the radii of two surfaces of a scene: a disc on another one, in a hole, or on a half-plane.

        ``material`` is that of the body of a, ``other`` that of the body of b if another.

        lenient: whether units that look like N and mm pass.
        """
        first, second = radii_between(a, b)
        if math.inf in (first, second):
            return cls.sphere_on_plane(min(first, second), material, other, lenient=lenient)
        if first < 0.0 or second < 0.0:
            sphere, cup = (first, second) if first > 0.0 else (second, first)
            return cls.sphere_in_cup(sphere, -cup, material, other, lenient=lenient)
        return cls.spheres(first, second, material, other, lenient=lenient)

    @classmethod
    def _of(
        cls, R: float, radii: tuple[float, ...], material: Material, other: Material | None, lenient: bool
    ) -> Hertz:
        check_materials(material, other)
        check_units((material, other), radii, lenient, stacklevel=4)
        return cls(R, contact_modulus(material, other), min(radii), lenient=lenient)

    @property
    def parameters(self) -> tuple[float, ...]:
        """K, n."""
        return 4.0 / 3.0 * self.contact_modulus * math.sqrt(self.effective_radius), 1.5

    @property
    def limit(self) -> float:
        """Indentation [m] at which the radius of the contact is 0.3 of the smallest radius of the bodies."""
        return (FLAT * self.smallest_radius) ** 2 / self.effective_radius


def _radius(name: str, value: float) -> float:
    return in_range(name, value, 0.0, math.inf, open_ends=True)
