"""Friction of continuous contact: forces of a slip velocity, with and without states of their own.

To add a law: a frozen dataclass that gives its row (:mod:`lcpflex.force_laws.layout`), and its case in :mod:`.kernels`,
which is loaded when a force is asked for: a scene is built without compiling.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.force_laws.friction.kernels import friction_forces

__all__ = ["friction_forces"]

__getattr__, __dir__ = attach(__name__)
