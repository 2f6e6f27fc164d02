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
    "DubowskyFreudenstein": "lcpflex.contact.laws.line_contact",
    "Esdu78035": "lcpflex.contact.laws.line_contact",
    "Goldsmith": "lcpflex.contact.laws.line_contact",
    "Hertz": "lcpflex.contact.laws.hertz",
    "HysteresisDamping": "lcpflex.contact.laws.hysteresis",
    "HysteresisFactor": "lcpflex.contact.laws.hysteresis",
    "Jankowski": "lcpflex.contact.laws.damping",
    "Johnson": "lcpflex.contact.laws.line_contact",
    "KelvinVoigt": "lcpflex.contact.laws.damping",
    "KuwabaraKono": "lcpflex.contact.laws.damping",
    "LankaraniNikraveshCylinder": "lcpflex.contact.laws.explicit_line_laws",
    "Liu": "lcpflex.contact.laws.explicit_line_laws",
    "LuGre": "lcpflex.contact.laws.bristles",
    "Material": "lcpflex.contact.laws.materials",
    "OwnLaw": "lcpflex.contact.laws.own_law",
    "Pereira": "lcpflex.contact.laws.explicit_line_laws",
    "PermanentIndentation": "lcpflex.contact.laws.damping",
    "Persson": "lcpflex.contact.laws.explicit_line_laws",
    "PowerFit": "lcpflex.contact.laws.power_fit",
    "PowerLaw": "lcpflex.contact.laws.power_law",
    "Radzimovsky": "lcpflex.contact.laws.line_contact",
    "RampCoulomb": "lcpflex.contact.laws.friction",
    "Ristow": "lcpflex.contact.laws.damping",
    "SmoothedCoulomb": "lcpflex.contact.laws.friction",
    "Threlfall": "lcpflex.contact.laws.friction",
    "Tsuji": "lcpflex.contact.laws.damping",
    "fit_power_law": "lcpflex.contact.laws.power_fit",
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
    "DubowskyFreudenstein",
    "Esdu78035",
    "Goldsmith",
    "Hertz",
    "HysteresisDamping",
    "HysteresisFactor",
    "Jankowski",
    "Johnson",
    "KelvinVoigt",
    "KuwabaraKono",
    "LankaraniNikraveshCylinder",
    "Liu",
    "LuGre",
    "Material",
    "OwnLaw",
    "Pereira",
    "PermanentIndentation",
    "Persson",
    "PowerFit",
    "PowerLaw",
    "Radzimovsky",
    "RampCoulomb",
    "Ristow",
    "SmoothedCoulomb",
    "Threlfall",
    "Tsuji",
    "fit_power_law",
    "prescribed_restitution",
    "restitution_of",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module at first use."""
    if name not in _HOME:
        from lcpflex.basics.arguments import nearest

        raise AttributeError(f"module 'lcpflex.laws' has no attribute {name!r}{nearest(name, __all__)}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from lcpflex.contact.laws.bristles import Bristle, LuGre
    from lcpflex.contact.laws.contact_law import ContactLaw
    from lcpflex.contact.laws.cylinder_pair import CylinderPair
    from lcpflex.contact.laws.damping import Jankowski, KelvinVoigt, KuwabaraKono, PermanentIndentation, Ristow, Tsuji
    from lcpflex.contact.laws.explicit_line_laws import LankaraniNikraveshCylinder, Liu, Pereira, Persson
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
    from lcpflex.contact.laws.line_contact import DubowskyFreudenstein, Esdu78035, Goldsmith, Johnson, Radzimovsky
    from lcpflex.contact.laws.materials import Material
    from lcpflex.contact.laws.own_law import OwnLaw
    from lcpflex.contact.laws.power_fit import PowerFit, fit_power_law
    from lcpflex.contact.laws.power_law import PowerLaw
    from lcpflex.contact.laws.restitution import prescribed_restitution, restitution_of
