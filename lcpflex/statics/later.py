"""What is loaded when a method of a place of rest asks for it: runs that begin there draw nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.statics.rests_as_result import draw_rest, stress_at_rest

__getattr__, __dir__ = attach(__name__)
