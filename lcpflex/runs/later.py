"""What is loaded for a run with sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.results.measures import Unmeasured, Window, columns_of, known, measured

__getattr__, __dir__ = attach(__name__)
