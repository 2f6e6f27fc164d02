"""Studies: many runs of one scene, and what they say together.

Each name is loaded when it is first used, so that the command line starts at once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.accuracy.graph_distance import graph_distance as graph_distance
    from lcpflex.accuracy.outputs import Output as Output
    from lcpflex.studies.convergence.methods import standard_methods as standard_methods
    from lcpflex.studies.convergence.points import WorkPoint as WorkPoint, WorkPrecision as WorkPrecision
    from lcpflex.studies.convergence.work_precision import work_precision as work_precision
    from lcpflex.studies.criteria import Criteria as Criteria
    from lcpflex.studies.model_order.report import (
        FidelityRun as FidelityRun,
        NextLevel as NextLevel,
        RightSize as RightSize,
    )
    from lcpflex.studies.model_order.right_size import right_size as right_size
    from lcpflex.studies.outcome import Outcome as Outcome, Verdict as Verdict
    from lcpflex.studies.stability_maps.acceleration_level import acceleration_level as acceleration_level
    from lcpflex.studies.stability_maps.chart import outcome_legend as outcome_legend
    from lcpflex.studies.stability_maps.stability_map import StabilityMap as StabilityMap
    from lcpflex.studies.stability_maps.study import stability as stability
    from lcpflex.studies.vibrations import Vibrations as Vibrations, small_vibrations as small_vibrations

__getattr__, __dir__ = attach(__name__, renamed={"NextRung": "NextLevel"})
