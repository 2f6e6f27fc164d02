"""Elastic constants of touching bodies, and whether their units fit their sizes."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from lcpflex.basics.options import keep_number
from lcpflex.errors import ModelError, ModelWarning, as_number, in_range, shown

__all__ = ["Material", "check_materials", "check_units", "contact_modulus"]

SOFT = 1e6  # [Pa]: rubbers are stiffer; all solids are below it in MPa but diamond
WIDE = 1.0  # [m]
WIDEST = 10.0  # [m]


@dataclass(frozen=True, slots=True)
class Material:
    """An isotropic elastic material.

    Attributes
    ----------
    youngs_modulus
        E > 0 [Pa]; infinite: a rigid body.
    poissons_ratio
        nu in (-1, 0.5).

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    youngs_modulus: float
    poissons_ratio: float

    def __post_init__(self) -> None:
        rigid = as_number(self.youngs_modulus) == math.inf and not isinstance(self.youngs_modulus, int)
        modulus = math.inf if rigid else in_range("youngs_modulus", self.youngs_modulus, 0.0, math.inf, open_ends=True)
        object.__setattr__(self, "youngs_modulus", modulus)
        keep_number(self, "poissons_ratio", -1.0, 0.5, open_ends=True)

    @property
    def compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa]."""
        return (1.0 - self.poissons_ratio**2) / self.youngs_modulus


def check_materials(material: Any, other: Any) -> None:
    """Two materials, the second None where it is the same, not both of them rigid."""
    for name, value in (("material", material), ("other", other)):
        if not isinstance(value, Material) and not (name == "other" and value is None):
            raise ModelError(f"{name}: {shown(value)} was given, expected a Material(youngs_modulus, poissons_ratio)")
    if material.compliance + (other or material).compliance == 0.0:
        raise ModelError("material, other: two rigid ones were given, expected one at least to be elastic")


def contact_modulus(material: Material, other: Material | None) -> float:
    """E* [Pa]: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; the second material is the first where it is None."""
    return 1.0 / (material.compliance + (other or material).compliance)


def check_units(materials: Iterable[Material | None], radii: Sequence[float], lenient: bool, stacklevel: int) -> None:
    """Moduli in Pa and radii in m, as far as their sizes tell.

    Moduli below 1e6 Pa, less than those of rubbers, beside a radius of 1 m or more are taken for N and mm: ModelError,
    with ``lenient`` a ModelWarning. All radii 10 m or more: ModelWarning. Soft gels of millimetres, rubber tyres of
    any size and large wheels pass.
    """
    softest = min(material.youngs_modulus for material in materials if material is not None)
    if softest < SOFT and max(radii) >= WIDE:
        text = (
            f"youngs_modulus, radius: {softest:g} Pa and {max(radii):g} m were given, which look like MPa and mm; "
            f"expected SI units, such as {1e6 * softest:g} Pa and {1e-3 * max(radii):g} m"
        )
        if not lenient:
            raise ModelError(f"{text}; lenient=True if they are what you mean")
        warnings.warn(text, ModelWarning, stacklevel=stacklevel)
    elif min(radii) >= WIDEST:
        text = f"radius: all radii are {min(radii):g} m or more, which look like mm; expected them in m"
        warnings.warn(text, ModelWarning, stacklevel=stacklevel)
