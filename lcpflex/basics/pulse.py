"""A pulse that calls compiled loops back to Python a few times a second, however long their steps take.

Kernels do not hold Python's lock, so a thread counts beats while one runs. A loop that sees another count than when it
was entered returns, and is entered again: in between Ctrl-C takes effect, and whoever waits is told how far it has
come. No result depends on when that happens.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

__all__ = ["BEATS", "beating"]

PERIOD = 0.2  # [s]: Ctrl-C is to take effect within a second, and a step of a large scene takes some tenths of one
BEATS = np.zeros(1, dtype=np.int64)  # the count, the same for all runs of the process

_lock = threading.Lock()
_runs = 0  # that want to be called back
_wanted = threading.Event()
_thread: threading.Thread | None = None


@contextmanager
def beating() -> Iterator[None]:
    """Within, beats are counted."""
    global _runs, _thread
    with _lock:
        _runs += 1
        if _thread is None or not _thread.is_alive():  # as in a process that was forked
            _thread = threading.Thread(target=_beat, name="lcpflex pulse", daemon=True)
            _thread.start()
        _wanted.set()
    try:
        yield
    finally:
        with _lock:
            _runs -= 1
            if not _runs:
                _wanted.clear()


def _beat() -> None:
    """Count while anybody wants it; no run, no beat."""
    pause = threading.Event()  # never set
    while True:
        _wanted.wait()
        pause.wait(PERIOD)
        with _lock:
            if _runs:  # not the one that ended meanwhile: whoever makes steps by himself makes as many as he asks for
                BEATS[0] += 1
