"""What is loaded when a method of a place of rest, or of a path, asks for it: runs that begin there draw nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.statics.path_chart import plot_path
    from lcpflex.statics.path_report import path_summary, path_to_dataframe
    from lcpflex.statics.rests_as_result import draw_rest, rests_as_result, stress_at_rest

__getattr__, __dir__ = attach(__name__)
