"""What is loaded when a method of a result asks for it: most runs draw, write and cut nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.accuracy.verify import verify
    from lcpflex.results.archive import read, write
    from lcpflex.results.charts import plot
    from lcpflex.results.film import animate
    from lcpflex.results.joint_reaction import joint_reaction
    from lcpflex.results.material_points import deflection_of, place_of, velocity_of
    from lcpflex.results.modal_coordinates import modal_coordinates
    from lcpflex.results.momentum import momentum_of
    from lcpflex.results.orientation import body_angle, body_orientation, body_spin
    from lcpflex.results.outside_values import without_functions
    from lcpflex.results.paraview import to_vtkhdf
    from lcpflex.results.plot import draw
    from lcpflex.results.sections import sections
    from lcpflex.results.state_at import state_at
    from lcpflex.results.stress_history import stress_history
    from lcpflex.results.summary import summary
    from lcpflex.results.tables import to_dataframe, to_xarray
    from lcpflex.results.verdict import verdict_of

__getattr__, __dir__ = attach(__name__)
