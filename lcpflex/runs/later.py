"""What is loaded for a run with sensors, one whose stepper is given by its name, one that is verified, and
one to a tolerance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.accuracy.tolerance import run_to_tolerance
    from lcpflex.accuracy.verify import is_cheap, verify
    from lcpflex.results.measures import Unmeasured, Window, columns_of, known, measured
    from lcpflex.steppers.event_driven.stepper import EventDriven
    from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
    from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
    from lcpflex.steppers.moreau_jean.stepper import MoreauJean

__getattr__, __dir__ = attach(__name__)
