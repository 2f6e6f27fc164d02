"""Section forces of a body of any kind: which of them it has."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from lcpflex.errors import ModelError, shown
from lcpflex.model.recovery import MeshShapes
from lcpflex.results.section_forces import SectionForces, body_of_result, mean_step, section_forces

if TYPE_CHECKING:
    from lcpflex.jit.kernel import IntArray
    from lcpflex.results.result import Result
    from lcpflex.results.spatial.section_forces import SpatialSectionForces
    from lcpflex.results.spatial.solid_sections import SolidSectionForces

    Sections: TypeAlias = SectionForces | SpatialSectionForces | SolidSectionForces

__all__ = ["sections"]


def sections(
    result: Result, body: str, x: Any, normal: Any, records: IntArray | None = None, step: float | None = None
) -> Sections:
    """See :meth:`lcpflex.results.result.Result.section`; ``records``: instants, ``step``: mean one; None: of all."""
    compiled, b = body_of_result(result, body, "section")
    if compiled.spatial and compiled.recovery and isinstance(compiled.recovery[b], MeshShapes):
        from lcpflex.results.spatial.solid_sections import solid_section_forces

        return solid_section_forces(result, compiled, b, x, normal, mean_step(result, step), records)
    if normal is not None:
        raise ModelError(f"normal: {shown(normal)} was given, expected none: {shown(body)} is no solid in space")
    if not compiled.spatial:
        return section_forces(result, body, x, records, step)
    from lcpflex.results.spatial.section_forces import spatial_section_forces

    return spatial_section_forces(result, compiled, b, x, mean_step(result, step), records)
