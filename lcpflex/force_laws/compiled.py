"""What laws take of their kernels, loaded when it is first asked for: a scene is built without numba."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.force_laws.damping.kernels import KINDS as DAMPING_KINDS
    from lcpflex.force_laws.elastic.kernels import KINDS as ELASTIC_KINDS
    from lcpflex.force_laws.friction.kernels import KINDS as FRICTION_KINDS, friction_forces

__all__ = ["DAMPING_KINDS", "ELASTIC_KINDS", "FRICTION_KINDS", "friction_forces"]

__getattr__, __dir__ = attach(__name__)
