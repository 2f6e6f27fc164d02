"""A function in a process of its own, which can be killed."""

from __future__ import annotations

import multiprocessing
import signal
import sys
import warnings
import weakref
from time import perf_counter
from typing import Any

from lcpflex.solvers.answers import Answer, asked

__all__ = ["Worker"]

_open: weakref.WeakSet[Worker] = weakref.WeakSet()


def _serve(connection: Any, others: list[Any], function: Any) -> None:
    """Answer one call after the other until the other side closes; the life of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interruption is for the one who asked
    for end in others:  # copies of ends that belong to the parent: while they are open, nobody would see it go
        end.close()
    while True:
        try:
            arguments, n = connection.recv()
        except (EOFError, OSError):
            return
        answer = asked(function, arguments, n)
        try:
            connection.send(answer)
        except (OSError, BrokenPipeError):
            return


class Worker:
    """A process that has the function; it lives for many calls, until one does not end in time or ends it."""

    def __init__(self, function: Any) -> None:
        kind = "fork" if "fork" in multiprocessing.get_all_start_methods() else "spawn"
        context: Any = multiprocessing.get_context(kind)
        self._connection, theirs = context.Pipe()
        others = [worker._connection for worker in _open] + [self._connection] if kind == "fork" else []
        self._process = context.Process(target=_serve, args=(theirs, others, function), daemon=True)
        with warnings.catch_warnings():
            # Of threads that hold locks while we fork: the child asks for none of them before the function does.
            warnings.simplefilter("ignore", DeprecationWarning)
            self._process.start()
        theirs.close()
        self.alive = True
        self._finish = weakref.finalize(self, _end, self._process, self._connection)
        _open.add(self)

    def ask(self, arguments: tuple[Any, ...], n: int, seconds: float) -> Answer:
        """What the function answers within so many seconds; after them, or if the process ends, it is no more."""
        began = perf_counter()
        try:
            self._connection.send((arguments, n))
            if self._connection.poll(seconds):
                answer: Answer = self._connection.recv()
                return answer
        except (EOFError, OSError):
            self.close()
            code = self._process.exitcode
            how = f"signal {signal.Signals(-code).name}" if code is not None and code < 0 else f"exit code {code}"
            return Answer(None, f"ended its process ({how})", seconds=perf_counter() - began)
        except BaseException:
            self.close()
            raise
        self.close()
        return Answer(
            None, f"was killed in its process after {seconds:.3g} s", seconds=perf_counter() - began, expired=True
        )

    def close(self) -> None:
        """Kill the process."""
        self.alive = False
        self._finish()


def _end(process: Any, connection: Any) -> None:
    connection.close()
    if sys.is_finalizing() or not process.is_alive():
        process.join(0.1)
        return
    process.kill()
    process.join()
