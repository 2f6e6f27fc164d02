"""Continuous contact-force laws: elastic, dissipative and friction laws, as ``lf.laws.Hertz``, ``lf.laws.LuGre``, ...

A :class:`ContactLaw` is made of the three, and given to a contact (``Scene.contact(..., law=)``) or a stepper
(``Smooth(law)``). Each name is loaded when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

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
    from lcpflex.force_laws.user_law import UserLaw

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
    "UserLaw",
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

__getattr__, __dir__ = attach(__name__, "lcpflex.laws", {"OwnLaw": "UserLaw"})
