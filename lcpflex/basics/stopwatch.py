"""Wall time of a run: what kernels take to compile or to load, and what is computing."""

from __future__ import annotations

import time
from typing import Any

__all__ = ["Stopwatch"]


class Stopwatch:
    """Counts from when it is made; compiling counts apart, also what is compiled in the midst of computing."""

    def __init__(self) -> None:
        from numba.core import event

        watch = self

        class Compiling(event.Listener):  # type: ignore[misc]
            def on_start(self, event: Any) -> None:
                watch._compile_begins()

            def on_end(self, event: Any) -> None:
                watch._compile_ends()

        self._began = time.perf_counter()
        self._loading = 0.0
        self._compiling, self._depth, self._since = 0.0, 0, 0.0
        self._listener = Compiling()

    def started(self) -> None:
        """Computing begins."""
        from numba.core import event

        event.register("numba:compile", self._listener)
        now = time.perf_counter()
        self._loading, self._began, self._compiling = now - self._began, now, 0.0

    def so_far(self) -> tuple[float, float]:
        """Time of computing since it began, and of compiling or loading [s]."""
        return time.perf_counter() - self._began - self._compiling, self._loading + self._compiling

    def ended(self) -> tuple[float, float]:
        """Time of computing, and of compiling or loading [s]."""
        from numba.core import event

        event.unregister("numba:compile", self._listener)
        return self.so_far()

    def _compile_begins(self) -> None:
        if self._depth == 0:
            self._since = time.perf_counter()
        self._depth += 1

    def _compile_ends(self) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._compiling += time.perf_counter() - self._since
