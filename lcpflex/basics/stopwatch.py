"""Wall time of a run: what kernels take to compile or to load, what is computing, and how much of that is allowed."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from lcpflex.basics import libs

__all__ = ["Budget", "Stopwatch", "budgeted"]


class Stopwatch:
    """Counts from when it is made; compiling counts apart, also what is compiled in the midst of computing."""

    def __init__(self) -> None:
        watch = self

        class Compiling(libs.numba_event.Listener):  # type: ignore[misc]
            def on_start(self, event: Any) -> None:
                watch._compile_begins()

            def on_end(self, event: Any) -> None:
                watch._compile_ends()

        self._began = time.perf_counter()
        self._loading = 0.0
        self._compiling, self._depth, self._since = 0.0, 0, 0.0
        self._listener = Compiling()
        self.computes = False  # whether computing has begun

    def started(self) -> None:
        """Computing begins."""
        libs.numba_event.register("numba:compile", self._listener)
        now = time.perf_counter()
        self._loading, self._began, self._compiling = now - self._began, now, 0.0
        self.computes = True

    def so_far(self) -> tuple[float, float]:
        """Time of computing since it began, and of compiling or loading [s]."""
        return time.perf_counter() - self._began - self._compiling, self._loading + self._compiling

    def ended(self) -> tuple[float, float]:
        """Time of computing, and of compiling or loading [s]."""
        libs.numba_event.unregister("numba:compile", self._listener)
        return self.so_far()

    def _compile_begins(self) -> None:
        if self._depth == 0:
            self._since = time.perf_counter()
        self._depth += 1

    def _compile_ends(self) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._compiling += time.perf_counter() - self._since


class Budget:
    """Seconds of computing that something may take, None for any; compilation is not counted."""

    def __init__(self, seconds: float | None, watch: Stopwatch) -> None:
        self.seconds, self._watch = seconds, watch

    @property
    def is_spent(self) -> bool:
        """Whether they are over."""
        return self.seconds is not None and self._watch.computes and self._watch.so_far()[0] > self.seconds


@contextmanager
def budgeted(seconds: float) -> Iterator[Budget]:
    """A budget that is spent from here on."""
    watch = Stopwatch()
    watch.started()
    try:
        yield Budget(seconds, watch)
    finally:
        watch.ended()
