"""How two runs of a scene differ: not at all, in rounding, in what they compute, in what they say, in how they end."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass

from tests.comparison.record import DIED, FAILED, REFUSED, Array, Record
from tests.comparison.sizes import Size, first_difference, sizes

__all__ = ["ALIKE", "ORDER", "Outcome", "compared"]

CLOSE = 1e-12  # shares up to this are rounding
LONGEST = 160  # characters of what one of two says, and the other does not
DIED_IN, ENDS, VERDICT, ASKED = "died", "end changed", "verdict changed", "asked differently"
DIFFERS, SAYS, ROUNDING = "differs", "says otherwise", f"equal to {CLOSE:g}"
FAILED_ALIKE, EQUAL, REFUSED_ALIKE = "failed alike, equal bits", "equal bits", "refused alike"
ALIKE = (FAILED_ALIKE, EQUAL, REFUSED_ALIKE)
ORDER = (DIED_IN, ENDS, VERDICT, ASKED, DIFFERS, SAYS, ROUNDING, *ALIKE)
NUMBER = r"[-+]?\d[\d,]*\.?\d*(?:e[-+]?\d+)?"
UNIT = r"(?: [Mkmµn]?(?=(?:m|s|m/s|J|N)\b))?"  # the prefix alone goes with its number


@dataclass(frozen=True, slots=True)
class Outcome:
    """What the comparison of a run says.

    Attributes
    ----------
    status
        One of ORDER, the first of them that is true.
    text
        All that differs.
    sizes
        How much, where there are two motions with other bits.
    """

    status: str
    text: str = ""
    sizes: tuple[Size, ...] = ()

    @property
    def rank(self) -> tuple[int, float]:
        """Differences first, and among these the large ones."""
        return ORDER.index(self.status), -max((size.share for size in self.sizes), default=0.0)


def compared(old: Record, new: Record) -> Outcome:
    """The outcome for one run of two checkouts."""
    if DIED in (old.how, new.how):
        return Outcome(DIED_IN, _ends(old, new))
    if old.arrays and new.arrays:
        return _of_results(old, new)
    if (old.how, old.error, bool(old.arrays)) != (new.how, new.error, bool(new.arrays)):
        return Outcome(ENDS, _ends(old, new))
    return Outcome(REFUSED_ALIKE if old.how == REFUSED else FAILED_ALIKE, old.error)


def _of_results(old: Record, new: Record) -> Outcome:
    bits, words = _other_bits(old, new), _other_words(old, new)
    if not bits and not words and (old.how, old.error, old.asked) == (new.how, new.error, new.asked):
        return Outcome(FAILED_ALIKE if old.how == FAILED else EQUAL, old.error)
    measured = tuple(sizes(old, new)) if bits else ()
    told = list(_told_otherwise(old, new, words))
    counts = _counts(old, new)
    status = _status(old, new, measured, told, bool(bits), bool(counts))
    texts = [
        _ends(old, new) if (old.how, old.error) != (new.how, new.error) else "",
        f"old asked for {old.asked}; new for {new.asked}" if old.asked != new.asked else "",
        *(str(size) for size in measured if size.share > 0.0),
        counts,
        f"first at t = {first_difference(old, new, bits):.6g}" if bits else "",
        *told,
        f"other bits: {', '.join(bits)}" if bits else "",
        f"other numbers in: {', '.join(words)}" if words and not told and not bits else "",
    ]
    return Outcome(status, "; ".join(text for text in texts if text), measured)


def _status(
    old: Record, new: Record, measured: tuple[Size, ...], told: list[str], bits: bool, other_counts: bool
) -> str:
    """The worst of what there is to say."""
    if old.how != new.how or _bare(old.error) != _bare(new.error):
        return ENDS
    if _bare(old.words["verdict"]) != _bare(new.words["verdict"]):
        return VERDICT
    if old.asked != new.asked:
        return ASKED
    if other_counts or any(size.share > CLOSE for size in measured):
        return DIFFERS
    return SAYS if told or not bits else ROUNDING


def _other_bits(old: Record, new: Record) -> list[str]:
    """Arrays, names and numbers that are not the same to the last bit, and arrays that one alone has."""
    both = [name for name in old.arrays if name in new.arrays]
    arrays = [name for name in both if not _same(old.arrays[name], new.arrays[name])]
    arrays += [f"{name} (only in old)" for name in old.arrays if name not in both]
    arrays += [f"{name} (only in new)" for name in new.arrays if name not in both]
    names = [name for name in old.names if name != "pairs" and old.names[name] != new.names.get(name)]
    return arrays + names + [k for k in old.numbers if json.dumps(old.numbers[k]) != json.dumps(new.numbers.get(k))]


def _same(a: Array, b: Array) -> bool:
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


def _other_words(old: Record, new: Record) -> list[str]:
    return [name for name in old.words if old.words[name] != new.words.get(name)]


def _told_otherwise(old: Record, new: Record, words: list[str]) -> Iterator[str]:
    """What one of them says and the other does not, numbers aside."""
    for name in words:
        if name == "events":  # which are counted
            continue
        before, after = (_texts(record.words.get(name)) for record in (old, new))
        gone = [text for text in before if _bare(text) not in map(_bare, after)]
        come = [text for text in after if _bare(text) not in map(_bare, before)]
        if gone or come:
            was, now = (" ".join(texts)[:LONGEST] or "nothing" for texts in (gone, come))
            yield f"{name}: old: {was}; new: {now}"


def _texts(value: object) -> list[str]:
    return [str(part) for part in value] if isinstance(value, list) else [] if value is None else [str(value)]


def _bare(text: str) -> str:
    """Without its numbers and the prefixes of their units."""
    return re.sub(NUMBER + UNIT, "#", text)


def _ends(old: Record, new: Record) -> str:
    return f"old: {old.error or 'ran to its end'}; new: {new.error or 'ran to its end'}"


def _counts(old: Record, new: Record) -> str:
    """Steps and events, where there are more or fewer, or others."""
    counted = [
        f"{was} -> {now} {name}"
        for name, was, now in (
            ("steps", old.numbers["steps"], new.numbers["steps"]),
            ("events", len(old.words["events"]), len(new.words["events"])),
        )
        if was != now
    ]
    others = [] if counted or old.words["events"] == new.words["events"] else ["events of other kinds or contacts"]
    return ", ".join(counted + others)
