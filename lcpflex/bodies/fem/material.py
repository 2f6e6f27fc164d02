"""Density and elastic constants of beams and meshes: numbers that a material can have, in units that fit each other."""

from __future__ import annotations

import math
import warnings
from typing import Any

from lcpflex.basics.arguments import positive
from lcpflex.basics.options import keep_number
from lcpflex.errors import ModelWarning

__all__ = ["check_material"]

SPEEDS = (10.0, 20_000.0)  # [m/s] of waves in a soft rubber, and more than in diamond
DIMENSIONLESS = 10.0  # density and modulus both below it are numbers of a scene without units


def check_material(part: Any, *, ratio: bool = True) -> None:
    """Positive finite density and modulus, a ratio in (-1, 0.5) if there is one; warns of waves that no material has.

    ``ratio``: False where Poisson's ratio is not to be looked at.
    """
    for name in ("density", "youngs_modulus"):
        object.__setattr__(part, name, positive(name, getattr(part, name)))
    if ratio and hasattr(part, "poissons_ratio"):
        keep_number(part, "poissons_ratio", -1.0, 0.5, open_ends=True)
    E, density = part.youngs_modulus, part.density
    speed = math.sqrt(E / density)
    if SPEEDS[0] <= speed <= SPEEDS[1] or 1e-3 * DIMENSIONLESS < min(E, density) <= max(E, density) < DIMENSIONLESS:
        return
    warnings.warn(
        f"youngs_modulus, density: {E:g} Pa and {density:g} kg/m^3 give waves of {speed:.3g} m/s, expected "
        f"{SPEEDS[0]:g} to {SPEEDS[1]:g} m/s: {_suspect(E, density)}",
        ModelWarning,
        stacklevel=4,
    )


def _suspect(E: float, density: float) -> str:
    """The unit that is wrong most likely."""
    if density < 1e-6:
        return "the numbers look like N, mm and t; write the modulus in Pa, the density in kg/m^3 and lengths in m"
    if math.sqrt(E / density) > SPEEDS[1]:
        return f"a density in g/cm^3? {density:g} g/cm^3 are {1e3 * density:g} kg/m^3"
    giga, mega = math.sqrt(1e9 * E / density), math.sqrt(1e6 * E / density)
    if SPEEDS[0] * 50.0 <= mega <= SPEEDS[1]:
        return f"a modulus in MPa? {E:g} MPa are {1e6 * E:g} Pa"
    if giga <= SPEEDS[1]:
        return f"a modulus in GPa? {E:g} GPa are {1e9 * E:g} Pa"
    return "the modulus is in Pa and the density in kg/m^3"
