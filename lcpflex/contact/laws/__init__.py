"""Continuous contact-force laws: elastic, dissipative and friction laws, as ``lf.laws.Hertz``, ``lf.laws.LuGre``, ...

A :class:`ContactLaw` is made of the three, and given to a contact (``Scene.contact(..., law=)``) or a stepper
(``Smooth(law)``). Each name is loaded when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOME = {
    "Ambrosio": "lcpflex.contact.laws.friction",
    "ArctangentCoulomb": "lcpflex.contact.laws.friction",
    "BengisuAkay": "lcpflex.contact.laws.friction",
    "Bristle": "lcpflex.contact.laws.bristles",
    "BrownMcPhee": "lcpflex.contact.laws.friction",
    "ContactLaw": "lcpflex.contact.laws.contact_law",
    "CylinderPair": "lcpflex.contact.laws.cylinder_pair",
    "Hertz": "lcpflex.contact.laws.hertz",
    "HysteresisDamping": "lcpflex.contact.laws.hysteresis",
    "HysteresisFactor": "lcpflex.contact.laws.hysteresis",
    "Jankowski": "lcpflex.contact.laws.damping",
    "KelvinVoigt": "lcpflex.contact.laws.damping",
    "KuwabaraKono": "lcpflex.contact.laws.damping",
    "LuGre": "lcpflex.contact.laws.bristles",
    "Material": "lcpflex.contact.laws.materials",
    "OwnLaw": "lcpflex.contact.laws.own_law",
    "PermanentIndentation": "lcpflex.contact.laws.damping",
    "PowerLaw": "lcpflex.contact.laws.power_law",
    "RampCoulomb": "lcpflex.contact.laws.friction",
    "Ristow": "lcpflex.contact.laws.damping",
    "SmoothedCoulomb": "lcpflex.contact.laws.friction",
    "Threlfall": "lcpflex.contact.laws.friction",
    "Tsuji": "lcpflex.contact.laws.damping",
    "prescribed_restitution": "lcpflex.contact.laws.restitution",
    "restitution_of": "lcpflex.contact.laws.restitution",
}

__all__ = [
    "Ambrosio",
    "ArctangentCoulomb",
    "BengisuAkay",
    "Bristle",
    "BrownMcPhee",
    "ContactLaw",
    "CylinderPair",
    "Hertz",
    "HysteresisDamping",
    "HysteresisFactor",
    "Jankowski",
    "KelvinVoigt",
    "KuwabaraKono",
    "LuGre",
    "Material",
    "OwnLaw",
    "PermanentIndentation",
    "PowerLaw",
    "RampCoulomb",
    "Ristow",
    "SmoothedCoulomb",
    "Threlfall",
    "Tsuji",
    "prescribed_restitution",
    "restitution_of",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module at first use."""
    if name not in _HOME:
        raise AttributeError(f"module 'lcpflex.laws' has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


if TYPE_CHECKING:
    from lcpflex.contact.laws.bristles import Bristle, LuGre
    from lcpflex.contact.laws.contact_law import ContactLaw
    from lcpflex.contact.laws.cylinder_pair import CylinderPair
    from lcpflex.contact.laws.damping import Jankowski, KelvinVoigt, KuwabaraKono, PermanentIndentation, Ristow, Tsuji
    from lcpflex.contact.laws.friction import (
        Ambrosio,
        ArctangentCoulomb,
        BengisuAkay,
        BrownMcPhee,
        RampCoulomb,
        SmoothedCoulomb,
        Threlfall,
    )
    from lcpflex.contact.laws.hertz import Hertz
    from lcpflex.contact.laws.hysteresis import HysteresisDamping, HysteresisFactor
    from lcpflex.contact.laws.materials import Material
    from lcpflex.contact.laws.own_law import OwnLaw
    from lcpflex.contact.laws.power_law import PowerLaw
    from lcpflex.contact.laws.restitution import prescribed_restitution, restitution_of
