"""Studies: many runs of one scene, and what they say together.

Each name is loaded when it is first used, so that the command line starts at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOME = {
    "Criteria": "lcpflex.studies.outcome",
    "FidelityRun": "lcpflex.studies.model_order.report",
    "NextRung": "lcpflex.studies.model_order.report",
    "Outcome": "lcpflex.studies.outcome",
    "Output": "lcpflex.studies.outputs",
    "RightSize": "lcpflex.studies.model_order.report",
    "StabilityMap": "lcpflex.studies.stability_maps.stability_map",
    "Verdict": "lcpflex.studies.outcome",
    "Vibrations": "lcpflex.studies.vibrations",
    "WorkPoint": "lcpflex.studies.convergence.points",
    "WorkPrecision": "lcpflex.studies.convergence.points",
    "acceleration_level": "lcpflex.studies.stability_maps.acceleration_level",
    "graph_distance": "lcpflex.studies.convergence.distance",
    "outcome_legend": "lcpflex.studies.stability_maps.chart",
    "right_size": "lcpflex.studies.model_order.right_size",
    "small_vibrations": "lcpflex.studies.vibrations",
    "stability": "lcpflex.studies.stability_maps.study",
    "standard_methods": "lcpflex.studies.convergence.methods",
    "work_precision": "lcpflex.studies.convergence.work_precision",
}

__all__ = [
    "Criteria",
    "FidelityRun",
    "NextRung",
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


def __getattr__(name: str) -> Any:
    """Load a public name from its module at first use."""
    if name not in _HOME:
        from lcpflex.basics.arguments import nearest

        raise AttributeError(f"module 'lcpflex.studies' has no attribute {name!r}{nearest(name, __all__)}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from lcpflex.studies.convergence.distance import graph_distance
    from lcpflex.studies.convergence.methods import standard_methods
    from lcpflex.studies.convergence.points import WorkPoint, WorkPrecision
    from lcpflex.studies.convergence.work_precision import work_precision
    from lcpflex.studies.model_order.report import FidelityRun, NextRung, RightSize
    from lcpflex.studies.model_order.right_size import right_size
    from lcpflex.studies.outcome import Criteria, Outcome, Verdict
    from lcpflex.studies.outputs import Output
    from lcpflex.studies.stability_maps.acceleration_level import acceleration_level
    from lcpflex.studies.stability_maps.chart import outcome_legend
    from lcpflex.studies.stability_maps.stability_map import StabilityMap
    from lcpflex.studies.stability_maps.study import stability
    from lcpflex.studies.vibrations import Vibrations, small_vibrations
