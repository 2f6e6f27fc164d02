"""Continuous contact-force laws: elastic, dissipative and friction laws, as ``lf.laws.Hertz``, ``lf.laws.LuGre``, ...

A :class:`ContactLaw` is made of the three, and given to a contact (``Scene.contact(..., law=)``) or a stepper
(``Smooth(law)``). Each name is loaded when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.force_laws.contact_law import ContactLaw as ContactLaw
    from lcpflex.force_laws.damping.dissipative import *
    from lcpflex.force_laws.damping.hysteresis import (
        HysteresisDamping as HysteresisDamping,
        HysteresisFactor as HysteresisFactor,
    )
    from lcpflex.force_laws.damping.restitution import (
        prescribed_restitution as prescribed_restitution,
        restitution_of as restitution_of,
    )
    from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair as CylinderPair
    from lcpflex.force_laws.elastic.explicit_line_laws import *
    from lcpflex.force_laws.elastic.hertz import Hertz as Hertz
    from lcpflex.force_laws.elastic.line_contact import (
        DubowskyFreudenstein as DubowskyFreudenstein,
        Esdu78035 as Esdu78035,
        Goldsmith as Goldsmith,
        Johnson as Johnson,
        Radzimovsky as Radzimovsky,
    )
    from lcpflex.force_laws.elastic.materials import Material as Material
    from lcpflex.force_laws.elastic.power_fit import *
    from lcpflex.force_laws.elastic.power_law import PowerLaw as PowerLaw
    from lcpflex.force_laws.friction.laws import *
    from lcpflex.force_laws.set_in_damper import impact_function as impact_function
    from lcpflex.force_laws.user_law import UserLaw as UserLaw

__getattr__, __dir__ = attach(__name__, "lcpflex.laws", {"OwnLaw": "UserLaw"})
