"""The public face of lcpflex: what can be called, with arguments that it takes."""

from __future__ import annotations

from functools import cache

from tests.property.fuzz.face import Face
from tests.property.fuzz.faces_of_laws import advice_faces, law_faces, mesh_faces
from tests.property.fuzz.faces_of_scenes import bodies_faces, run_faces, scene_faces, sensor_faces
from tests.property.fuzz.faces_of_solvers import solver_faces
from tests.property.fuzz.faces_of_spatial_bodies import spatial_bodies_faces
from tests.property.fuzz.faces_of_spatial_scenes import spatial_parts_faces
from tests.property.fuzz.faces_of_studies import gallery_faces, study_faces

__all__ = ["INTERNAL", "OUTPUTS", "PLAIN", "SLOW", "faces"]

# Made by the library and handed out: users read them.
OUTPUTS = {
    "Result",
    "Rest",
    "EquilibriumPath",
    "Solution",
    "StateMechanics",
    "Replay",
    "CrossCheck",
    "FidelityRun",
    "NextLevel",
    "RightSize",
    "StabilityMap",
    "Vibrations",
    "WorkPoint",
    "WorkPrecision",
    "Verdict",
    "SlotParts",
    "SpatialPoint",
    "PowerFit",
    "Case",
    "ContactAdvice",
}
# Exceptions, enumerations, protocols, functions without arguments.
PLAIN = {
    "LcpflexError",
    "ModelError",
    "ModelWarning",
    "SolverError",
    "StepError",
    "ToleranceError",
    "EnergyGrowth",
    "Status",
    "Outcome",
    "HysteresisFactor",
    "HasMesh",
    "HasModes",
    "scenes",
    "warmup_cases",
    "__version__",
    "PAIRS",
    "PER_WAVELENGTH",
}

# Methods that the library calls, between its own parts.
INTERNAL = {
    *(
        "ask",
        "attempt",
        "check",
        "holder",
        "compiled",
        "condensed",
        "indents",
        "judged",
        "keep",
        "label",
        "limits",
        "measured_in",
        "outside",
        "pieces",
        "residual_parts",
    ),
    *("put", "settings", "start", "system", "told_apart"),
}

# A call of theirs takes a tenth of a second or more.
SLOW = {
    "work_precision", "right_size", "stability", "craig_bampton", "free_interface", "residual_compliance",
    "sub_regional", "unreduced", "Continuum.reduce", "SolidOfRevolution.reduce", "Matrices.reduce", "small_vibrations",
    "gallery.meshed_ball", "gallery.meshed_rod", "gallery.meshed_sphere_on_rod", "Result.animate", "cross_check",
    "replay", "all_solvers", "simulate", "path", "EquilibriumPath.plot", "Rest.draw",
    "gallery.bar_with_foot", "meshes.half_disc", "meshes.half_section_of_sphere",
}  # fmt: skip


@cache
def faces() -> tuple[Face, ...]:
    """Everything."""
    parts = (
        bodies_faces,
        spatial_bodies_faces,
        spatial_parts_faces,
        scene_faces,
        run_faces,
        sensor_faces,
        solver_faces,
        law_faces,
        mesh_faces,
        advice_faces,
        gallery_faces,
        study_faces,
    )
    return tuple(face for part in parts for face in part())
