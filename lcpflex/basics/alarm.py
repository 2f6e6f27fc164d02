"""A reason not to trust a result: words for readers, and their parts for programs."""

from __future__ import annotations

from typing import Any

__all__ = ["FINER", "Alarm"]

FINER = "take a shorter step, or tighter tolerances"  # advice where nothing tells more


class Alarm(str):
    """A clause with what to do: ``contact 'lock' is 10 mm deep at t = 0.25 s: take steps of at most 1e-05 s``.

    It is a text, as it was when such clauses had no parts, and stays one wherever texts are kept.

    Attributes
    ----------
    what
        Kind of the fault, the same words in all runs, such as "penetration".
    where
        Of what: a contact, joint, body or load as messages name it; empty: of the whole.
    when
        At what time, the first or the worst [s]; None: not known, or all the time.
    amount
        How much, in the unit that the text has without its prefix (m, J, or a ratio); None: no number tells it.
    advice
        What to do.
    """

    what: str
    where: str
    when: float | None
    amount: float | None
    advice: str
    _fields = ("clause", "what", "where", "when", "amount", "advice")  # of files

    def __new__(
        cls,
        clause: str,
        what: str = "",
        where: str = "",
        when: float | None = None,
        amount: float | None = None,
        advice: str = "",
    ) -> Alarm:
        """``clause``: all but the advice, in words."""
        alarm = super().__new__(cls, f"{clause}: {advice}" if advice else clause)
        alarm.what, alarm.where, alarm.when, alarm.amount, alarm.advice = what or clause, where, when, amount, advice
        return alarm

    @property
    def clause(self) -> str:
        """All but the advice, in words."""
        return str(self).removesuffix(f": {self.advice}") if self.advice else str(self)

    @property
    def text(self) -> str:
        """All of it, in words."""
        return str(self)

    def of(self, where: str) -> Alarm:
        """The same as the predicate of a sentence about ``where``."""
        return Alarm(f"{where} {self.clause}", self.what, where, self.when, self.amount, self.advice)

    def __getnewargs__(self) -> tuple[Any, ...]:
        """For copies."""
        return tuple(getattr(self, name) for name in self._fields)
