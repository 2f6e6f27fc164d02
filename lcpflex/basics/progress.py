"""Words while it works: a bar on a terminal, elsewhere a line a minute by the logger ``lcpflex``.

Whoever works for long opens a :class:`Progress` and calls :func:`look` where it comes by. What works within (a run
within a study) opens one, too: the outermost one is heard, and its line ends with the words of those within.
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable
from contextvars import ContextVar, Token
from typing import Any

from lcpflex.basics import libs

__all__ = ["Progress", "look", "tell"]

EVERY = 60.0  # [s] between lines
LATE = 2.0  # [s] after which a bar is shown that nobody has asked for
LOGGER = logging.getLogger("lcpflex")
now = time.perf_counter

_open: ContextVar[tuple[Progress, ...]] = ContextVar("work under way", default=())


def tell(words: str, level: int = logging.INFO, quiet: bool = False) -> None:
    """Say ``words`` by the logger; on stderr where nobody has set up logging, unless they are to be ``quiet`` there.

    Python itself shows warnings there, and nothing less, where logging is not set up.
    """
    if LOGGER.hasHandlers():
        LOGGER.log(level, "%s", words)
        return
    muted = LOGGER.disabled or LOGGER.manager.disable >= level or level < LOGGER.level
    if not (quiet or muted) and sys.stderr is not None:
        print(f"lcpflex: {words}", file=sys.stderr, flush=True)


def look() -> None:
    """Say how far what is under way has come, where a line is due."""
    if under_way := _open.get():
        under_way[0].look(under_way[1:])


class Progress:
    """Of one piece of work, as a context.

    Parameters
    ----------
    progress
        True: a bar. None: a bar on a terminal, after two seconds, and elsewhere a line a minute. False: no bar, and
        the lines by the logger alone.
    words
        What a line says; None: how many of ``total`` are done.
    what
        How a line begins: the name of the function at work.
    bar
        Whether it may show one.
    options
        Of the bar, a ``tqdm``.
    """

    def __init__(
        self,
        progress: bool | None,
        words: Callable[[], str] | None = None,
        *,
        what: str = "",
        total: float | None = None,
        unit: str = "",
        initial: float = 0.0,
        bar: bool = True,
        **options: Any,
    ) -> None:
        self._progress, self._may_show = progress, bar
        self._words = words or self._counted
        self._what, self._total, self._unit, self._at = what, total, unit, ""
        self.n = initial
        self._options = {"total": total, "unit": unit, "initial": initial, **options}
        self._bar: Any = None
        self._token: Token[tuple[Progress, ...]] | None = None

    def __enter__(self) -> Progress:
        self._began = self._said = now()
        shows = _on_terminal() if self._progress is None else self._progress
        if shows and self._may_show:
            self._bar = libs.tqdm(delay=0.0 if self._progress else LATE, **self._options)
        self._token = _open.set((*_open.get(), self))
        return self

    def __exit__(self, *error: object) -> None:
        assert self._token is not None
        _open.reset(self._token)
        if self._bar is not None:
            self._bar.close()

    def update(self, n: float = 1) -> None:
        """So much more is done."""
        self.n += n
        if self._bar is not None:
            self._bar.update(n)
        look()

    def at(self, place: str) -> None:
        """Which part is under way."""
        self._at = place
        if self._bar is not None:
            self._bar.set_postfix_str(place)

    def look(self, within: tuple[Progress, ...] = ()) -> None:
        """Say how far this and what is ``within`` have come, where there is no bar and a line is due."""
        if now() - self._said < EVERY or any(one._bar is not None for one in (self, *within)):
            return
        self._said = now()
        begins = f"{self._what} " if self._what else ""
        lines = [one._words() for one in (self, *within)]
        tell(f"{begins}after {self._said - self._began:.0f} s: {'; '.join(lines)}", quiet=self._progress is False)

    def _counted(self) -> str:
        """How many are done, and which one is under way."""
        of = "" if self._total is None else f" of {self._total:g}"
        return f"{self.n:g}{of} {self._unit}s done{f', now {self._at}' if self._at else ''}"


def _on_terminal() -> bool:
    """Whether what is written to stderr is seen as it comes, and may be overwritten."""
    asked = getattr(sys.stderr, "isatty", None)
    return bool(asked and asked())
