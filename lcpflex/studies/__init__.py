"""Studies: many runs of one scene, and what they say together.

Each name is loaded when it is first used, so that the command line starts at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.studies.convergence.distance import graph_distance
    from lcpflex.studies.convergence.methods import standard_methods
    from lcpflex.studies.convergence.points import WorkPoint, WorkPrecision
    from lcpflex.studies.convergence.work_precision import work_precision
    from lcpflex.studies.criteria import Criteria
    from lcpflex.studies.model_order.report import FidelityRun, NextLevel, RightSize
    from lcpflex.studies.model_order.right_size import right_size
    from lcpflex.studies.outcome import Outcome, Verdict
    from lcpflex.studies.outputs import Output
    from lcpflex.studies.stability_maps.acceleration_level import acceleration_level
    from lcpflex.studies.stability_maps.chart import outcome_legend
    from lcpflex.studies.stability_maps.stability_map import StabilityMap
    from lcpflex.studies.stability_maps.study import stability
    from lcpflex.studies.vibrations import Vibrations, small_vibrations

__all__ = [
    "Criteria",
    "FidelityRun",
    "NextLevel",
    "Outcome",
    "Output",
    "RightSize",
    "StabilityMap",
    "Verdict",
    "Vibrations",
    "WorkPoint",
    "WorkPrecision",
    "acceleration_level",
    "graph_distance",
    "outcome_legend",
    "right_size",
    "small_vibrations",
    "stability",
    "standard_methods",
    "work_precision",
]

__getattr__, __dir__ = attach(__name__, renamed={"NextRung": "NextLevel"})
