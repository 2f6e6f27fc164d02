"""What is planar of the layout of a model."""

from __future__ import annotations

__all__ = ["N_RIGID"]

N_RIGID = 3  # coordinates of a body as a rigid one, x, y, angle; its modal ones come behind them
