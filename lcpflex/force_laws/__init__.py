"""Continuous contact-force laws: elastic, dissipative and friction laws, as ``lf.laws.Hertz``, ``lf.laws.LuGre``, ...

A :class:`ContactLaw` is made of the three, and given to a contact (``Scene.contact(..., law=)``) or a stepper
(``Smooth(law)``). Each name is loaded when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOME = {
    "Ambrosio": "lcpflex.force_laws.friction.laws",
    "ArctangentCoulomb": "lcpflex.force_laws.friction.laws",
    "BengisuAkay": "lcpflex.force_laws.friction.laws",
    "Bristle": "lcpflex.force_laws.friction.bristles",
    "BrownMcPhee": "lcpflex.force_laws.friction.laws",
    "ContactLaw": "lcpflex.force_laws.contact_law",
    "CylinderPair": "lcpflex.force_laws.elastic.cylinder_pair",
    "DubowskyFreudenstein": "lcpflex.force_laws.elastic.line_contact",
    "Esdu78035": "lcpflex.force_laws.elastic.line_contact",
    "Goldsmith": "lcpflex.force_laws.elastic.line_contact",
    "Hertz": "lcpflex.force_laws.elastic.hertz",
    "HysteresisDamping": "lcpflex.force_laws.damping.hysteresis",
    "HysteresisFactor": "lcpflex.force_laws.damping.hysteresis",
    "Jankowski": "lcpflex.force_laws.damping.dissipative",
    "Johnson": "lcpflex.force_laws.elastic.line_contact",
    "KelvinVoigt": "lcpflex.force_laws.damping.dissipative",
    "KuwabaraKono": "lcpflex.force_laws.damping.dissipative",
    "LankaraniNikraveshCylinder": "lcpflex.force_laws.elastic.explicit_line_laws",
    "Liu": "lcpflex.force_laws.elastic.explicit_line_laws",
    "LuGre": "lcpflex.force_laws.friction.bristles",
    "Material": "lcpflex.force_laws.elastic.materials",
    "OwnLaw": "lcpflex.force_laws.user_law",
    "Pereira": "lcpflex.force_laws.elastic.explicit_line_laws",
    "PermanentIndentation": "lcpflex.force_laws.damping.dissipative",
    "Persson": "lcpflex.force_laws.elastic.explicit_line_laws",
    "PowerFit": "lcpflex.force_laws.elastic.power_fit",
    "PowerLaw": "lcpflex.force_laws.elastic.power_law",
    "Radzimovsky": "lcpflex.force_laws.elastic.line_contact",
    "RampCoulomb": "lcpflex.force_laws.friction.laws",
    "Ristow": "lcpflex.force_laws.damping.dissipative",
    "SmoothedCoulomb": "lcpflex.force_laws.friction.laws",
    "Threlfall": "lcpflex.force_laws.friction.laws",
    "Tsuji": "lcpflex.force_laws.damping.dissipative",
    "fit_power_law": "lcpflex.force_laws.elastic.power_fit",
    "prescribed_restitution": "lcpflex.force_laws.damping.restitution",
    "restitution_of": "lcpflex.force_laws.damping.restitution",
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
    from lcpflex.force_laws.contact_law import ContactLaw
    from lcpflex.force_laws.damping.dissipative import (
        Jankowski,
        KelvinVoigt,
        KuwabaraKono,
        PermanentIndentation,
        Ristow,
        Tsuji,
    )
    from lcpflex.force_laws.damping.hysteresis import HysteresisDamping, HysteresisFactor
    from lcpflex.force_laws.damping.restitution import prescribed_restitution, restitution_of
    from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
    from lcpflex.force_laws.elastic.explicit_line_laws import LankaraniNikraveshCylinder, Liu, Pereira, Persson
    from lcpflex.force_laws.elastic.hertz import Hertz
    from lcpflex.force_laws.elastic.line_contact import DubowskyFreudenstein, Esdu78035, Goldsmith, Johnson, Radzimovsky
    from lcpflex.force_laws.elastic.materials import Material
    from lcpflex.force_laws.elastic.power_fit import PowerFit, fit_power_law
    from lcpflex.force_laws.elastic.power_law import PowerLaw
    from lcpflex.force_laws.friction.bristles import Bristle, LuGre
    from lcpflex.force_laws.friction.laws import (
        Ambrosio,
        ArctangentCoulomb,
        BengisuAkay,
        BrownMcPhee,
        RampCoulomb,
        SmoothedCoulomb,
        Threlfall,
    )
    from lcpflex.force_laws.user_law import OwnLaw
