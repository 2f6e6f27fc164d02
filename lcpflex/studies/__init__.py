"""Studies: many runs of one scene, and what they say together."""

from __future__ import annotations

from lcpflex.studies.graph_distance import graph_distance
from lcpflex.studies.outcome import Criteria, Outcome
from lcpflex.studies.stability import stability
from lcpflex.studies.stability_map import StabilityMap

__all__ = ["Criteria", "Outcome", "StabilityMap", "graph_distance", "stability"]
