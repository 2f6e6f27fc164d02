"""Exceptions of lcpflex; nothing else ever leaves the library on purpose.

Every message names the argument, the value that was given and what was expected.
"""

from __future__ import annotations

from typing import Any

__all__ = ["LcpflexError", "ModelError", "SolverError", "StepError"]


class LcpflexError(Exception):
    """Base of all exceptions that lcpflex raises itself."""


class ModelError(LcpflexError, ValueError):
    """A scene, body, joint, load, contact or option that cannot be: raised before time is spent."""


class SolverError(LcpflexError, RuntimeError):
    """A contact problem was not solved to its tolerance.

    ``solution`` holds the best point found, with its residual and status.
    """

    def __init__(self, message: str, solution: Any = None) -> None:
        super().__init__(message)
        self.solution = solution


class StepError(LcpflexError, RuntimeError):
    """A simulation could not go on.

    ``result`` holds everything recorded up to then, marked incomplete; ``time`` [s], ``step``
    (count) and ``contacts`` (names of the active ones) say where it stopped.
    """

    def __init__(
        self,
        message: str,
        *,
        time: float = float("nan"),
        step: int = 0,
        contacts: tuple[str, ...] = (),
        result: Any = None,
    ) -> None:
        super().__init__(message)
        self.time = time
        self.step = step
        self.contacts = contacts
        self.result = result
