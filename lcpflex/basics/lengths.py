"""Lengths of vectors of one to three components."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["lengths"]


def lengths(vectors: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Of vectors (..., 1 to 3)."""
    if vectors.shape[-1] == 2:
        return np.asarray(np.hypot(vectors[..., 0], vectors[..., 1]))
    return np.asarray(np.abs(vectors[..., 0]) if vectors.shape[-1] == 1 else np.linalg.norm(vectors, axis=-1))
