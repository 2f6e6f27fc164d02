"""One call with one strange value: whether it ends in time, in a result or in an error that helps."""

from __future__ import annotations

import contextlib
import io
import re
import resource
import signal
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from numba.core.compiler_lock import global_compiler_lock

import lcpflex as lf

__all__ = ["Ending", "ending_of", "limited_memory"]

SECONDS = 10.0  # of computing
BUSY = 6.0  # times that, of a machine that others use, too
LONGEST = 500  # characters of a message
MEMORY = 3 * 2**30  # bytes beyond what the process has


class TooLate(BaseException):
    """The time of a call is over."""


@dataclass(frozen=True)
class Ending:
    """How a call ended: "result", "refused", or what is wrong with it."""

    kind: str
    said: str = ""


def ending_of(call: Callable[[], Any], argument: str, others: Iterable[str] = ()) -> Ending:
    """How ``call`` ends, in which ``argument`` is strange; a message may name one of ``others``."""
    began = time.process_time(), time.monotonic()
    before = signal.signal(signal.SIGALRM, lambda *_: _alarm(*began))
    signal.setitimer(signal.ITIMER_REAL, SECONDS)
    try:
        with (
            warnings.catch_warnings(),
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(io.StringIO()),
        ):
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", lf.ModelWarning)
            result = call()
    except lf.LcpflexError as error:
        return _refusal(str(error), argument, others)
    except TooLate:
        return Ending("too late")
    except MemoryError as error:
        return Ending("memory", str(error)[:200])
    except Exception as error:
        return Ending("bare", f"{type(error).__name__}: {str(error)[:200]}")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    return Ending("result", f"{type(result).__name__}")


def _refusal(message: str, argument: str, others: Iterable[str]) -> Ending:
    if len(message) > LONGEST:
        return Ending("long", message[:100])
    words = re.split(r"[^A-Za-z0-9]+", message.casefold())
    if not (any(_names(one, words) for one in (argument, *others)) or argument in message):
        return Ending("unnamed", message)
    if "expected" not in words:
        return Ending("no expectation", message)
    return Ending("refused", message)


def _names(argument: str, words: list[str]) -> bool:
    return all(part in words for part in argument.casefold().split("_") if part)


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        yield


def _alarm(computing: float, began: float) -> None:
    """Raise TooLate, but look again later where other processes had the machine, or a kernel is compiled."""
    spent, waited = time.process_time() - computing, time.monotonic() - began
    if global_compiler_lock.is_locked() or (spent < SECONDS and waited < BUSY * SECONDS):
        signal.setitimer(signal.ITIMER_REAL, 1.0)
        return
    raise TooLate


@contextlib.contextmanager
def limited_memory() -> Iterator[None]:
    """No more than MEMORY beyond what is in use: what asks for more gets a MemoryError."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm", encoding="ascii") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
