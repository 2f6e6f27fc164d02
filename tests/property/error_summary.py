"""What a log of :mod:`tests.property.error_campaign` shows, and whether that is enough."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.property.error_judge import MEASURES

__all__ = ["Criterion", "covered", "criteria", "failures", "ratio", "summary"]

Line = dict[str, Any]
Claim = Callable[[Line, str], float | None]

FLOOR = 1e-5  # of the extent, or the largest speed: runs that are less wrong are not judged
EXACT = 1e-9  # that of methods with an error control of high order, whose truth is the same at 1e-12
EXACTLY = ("events", "runge-kutta", "stiff")
SLOW = 0.1  # of the speed of a fall through the length of a body: slower scenes are at rest
BETTER = 4.0  # times as good as the run a truth by time stepping must be
LIMITS = {"place": 0.95, "turn": 0.92, "speed": 0.90, "rms": 0.90}  # share of the runs with E >= truth
HALF = 0.97  # with E >= half the truth
MEDIAN = 2.5
WORSE = 0.04  # by how much a stepper may be worse than all
OFTEN = 10  # runs that a stepper must have for that
LATE, IN_TIME = 1.1, 0.92  # times the true horizon, and the share of those that are no later
EARLY, NOT_SOONER = 0.5, 0.80
OFF = 0.02  # of the extent or the largest speed: a run that is less off is right
FALSE = 0.03  # of the right runs that may be called not to be trusted
NAMES = {2: "plane", 3: "space"}


def ratio(line: Line, name: str, claim: Claim | None = None) -> float | None:
    """E over the truth; None where the truth is too small to be told, or hardly better than the run."""
    true = line["true"][name]
    if true is None or true < _floor(line, name):
        return None
    if line["references"][0] != "EventDriven" and line["apart"][name] * BETTER > true:
        return None
    claimed = line["claimed"][name] if claim is None else claim(line, name)
    return None if claimed is None else float(claimed / true)


def _floor(line: Line, name: str) -> float:
    """The least error that is judged [m] or [m/s]; at rest, speeds are those of rounding, of which nothing is told."""
    size = line["extent"] if name in MEASURES[:2] else max(line["fastest"], SLOW * line["speed"])
    return float((EXACT if line["stepper"] in EXACTLY else FLOOR) * size)


def _by_itself(line: Line, name: str) -> float | None:
    """E of fixed steps by the run at a quarter of the step alone, which is never of the truth's method."""
    own = [found[name] for what, _, found in line["reruns"] if what == "a quarter of the step"]
    return 2.0 * own[0] if own and line["references"][0] == "EventDriven" else None


def _confirmed(line: Line, name: str) -> float | None:
    """E where another method than the truth's, too, shows the error of the run."""
    return line["claimed"][name] if line["apart"][name] * BETTER <= line["true"][name] else None


def _ratios(lines: Iterable[Line], name: str, claim: Claim | None = None) -> list[float]:
    return [r for line in lines if (r := ratio(line, name, claim)) is not None]


def covered(lines: Iterable[Line], least: float, names: Iterable[str] = MEASURES) -> tuple[int, int]:
    """How many of how many ratios are ``least`` or more."""
    lines = list(lines)
    ratios = [r for name in names for r in _ratios(lines, name)]
    return sum(r >= least for r in ratios), len(ratios)


def _understated(line: Line) -> bool:
    """Whether a run is off by more than it says and 2 %, up to the time to which it says that it holds."""
    for name in MEASURES:
        found = ratio(line | line["held"], name)
        size = line["extent" if name in MEASURES[:2] else "fastest"]
        if found is not None and found < 1.0 and line["held"]["true"][name] > OFF * size:
            return True
    return False


def _right(line: Line) -> bool:
    """Of runs whose truth lasts to the end: a verdict may be of what comes later."""
    if line["until"] < 0.999 * line["duration"]:
        return False
    sizes = {"place": line["extent"], "turn": line["extent"], "speed": line["fastest"]}
    return all(line["true"][name] <= OFF * size for name, size in sizes.items())


def _trusted(line: Line) -> bool:
    return bool(line["verdict"] == "Trusted")


def failures(lines: Iterable[Line]) -> list[str]:
    """The runs called Trusted that are off by more than they say and 2 %."""
    return [f"{line['dimension']}D seed {line['seed']}" for line in lines if _trusted(line) and _understated(line)]


def _horizons(lines: Iterable[Line]) -> list[float]:
    """Stated over true horizons, where one of them is before the end of the truth; a lower bound of the true one."""
    found = []
    for line in lines:
        true, stated = line["parted"] or line["until"], min(line["horizon"], line["until"])
        if line["parted"] or stated < 0.999 * line["until"]:
            found.append(stated / true)
    return found


def summary(lines: list[Line]) -> str:
    """Counts and shares of each dimension and of both, by stepper, and what fails."""
    words = [
        f"Judged: runs off by {FLOOR:g} of the extent or of the largest speed ({', '.join(EXACTLY)}: "
        f"{EXACT:g}, the truth being the same method at 1e-12), in a measure."
    ]
    for dimension in sorted({line["dimension"] for line in lines}):
        own = [line for line in lines if line["dimension"] == dimension]
        words += ["", _counts(NAMES[dimension], own), "", *_table(own)]
    told = [str(one) for one in criteria(lines)]
    return "\n".join([*words, "", "Both:", "", *_table(lines), "", *told, "", *_found(lines)])


def _counts(name: str, lines: list[Line]) -> str:
    counts = Counter(line["outcome"] for line in lines)
    judged = [line for line in lines if line["outcome"] == "judged"]
    off = [line for line in judged if any(ratio(line, name) is not None for name in MEASURES)]
    alike = sum(line["references"][0] in [kind for _, kind, _ in line["reruns"]] for line in off)
    told = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    return (
        f"In {name}: {len(lines)} scenes ({told}); {len(judged) - len(off)} of the judged are off by less than told "
        f"here in all measures; of the others {alike} have a rerun of the method of the truth."
    )


def _table(lines: list[Line]) -> list[str]:
    head = "| | runs | " + " | ".join(f"{name}: median, >= 1, >= .5" for name in MEASURES) + " | cost |"
    words = [head, "|---" * (len(MEASURES) + 3) + "|"]
    judged = [line for line in lines if line["outcome"] == "judged"]
    groups = [("all", judged)] + [
        (name, [line for line in judged if line["stepper"] == name]) for name in sorted({x["stepper"] for x in judged})
    ]
    for label, own in groups:
        off = [line for line in own if any(ratio(line, name) is not None for name in MEASURES)]
        if not off:
            continue
        cost = f"{np.median([line['cost'] for line in own]):.1f}"
        words.append(f"| {label} | {len(off)} of {len(own)} | {' | '.join(_cell(own, n) for n in MEASURES)} | {cost} |")
    for label, claim in (("confirmed by two methods", _confirmed), ("h/4 alone, truth event-driven", _by_itself)):
        words.append(f"| {label} | | {' | '.join(_cell(judged, name, claim) for name in MEASURES)} | |")
    return words


def _cell(lines: list[Line], name: str, claim: Claim | None = None) -> str:
    ratios = np.array(_ratios(lines, name, claim))
    if not len(ratios):
        return "-"
    return f"{len(ratios)}: {np.median(ratios):.2f}, {(ratios >= 1.0).mean():.0%}, {(ratios >= 0.5).mean():.0%}"


@dataclass(frozen=True)
class Criterion:
    """What a campaign must show, and what it shows."""

    what: str
    found: float
    limit: float
    count: int  # of runs that it is of
    most: bool = False  # whether the limit is the largest that may be found

    @property
    def holds(self) -> bool:
        """Also where there is nothing that it is of."""
        return not self.count or (self.found <= self.limit if self.most else self.found >= self.limit)

    def __str__(self) -> str:
        sign, holds = "<=" if self.most else ">=", "holds" if self.holds else "DOES NOT HOLD"
        return f"- {self.what}: {self.found:.3f} of {self.count}, to be {sign} {self.limit:.2f}: {holds}"


def criteria(lines: Iterable[Line]) -> list[Criterion]:
    """All that a campaign over both dimensions must show."""
    judged = [line for line in lines if line["outcome"] == "judged"]
    found = [one for name, limit in LIMITS.items() for one in _of_measure(judged, name, limit)]
    apart = _horizons(judged)
    found += [
        Criterion("horizon at most 1.1 times the true one", _share(apart, lambda r: r <= LATE), IN_TIME, len(apart)),
        Criterion("horizon at least half of it", _share(apart, lambda r: r >= EARLY), NOT_SOONER, len(apart)),
    ]
    right = [line for line in judged if _right(line)]
    alarmed = _share(right, lambda line: line["verdict"].startswith("NOT"))
    trusted = [line for line in judged if _trusted(line)]
    low = float(len(failures(judged)))
    return [
        *found,
        Criterion("right runs called not to be trusted", alarmed, FALSE, len(right), True),
        Criterion("runs called trusted, off by more than they say and 2 %", low, 0.0, len(trusted), True),
    ]


def _of_measure(judged: list[Line], name: str, limit: float) -> list[Criterion]:
    whole, count = covered(judged, 1.0, [name])
    half, _ = covered(judged, 0.5, [name])
    share, median = max(1, count), float(np.median(_ratios(judged, name) or [1.0]))
    found = [
        Criterion(f"{name}: E >= truth", whole / share, limit, count),
        Criterion(f"{name}: E >= half the truth", half / share, HALF, count),
        Criterion(f"{name}: median of E / truth", median, MEDIAN, count, True),
    ]
    for stepper in sorted({line["stepper"] for line in judged}):
        good, own = covered([line for line in judged if line["stepper"] == stepper], 1.0, [name])
        if own >= OFTEN:
            found.append(Criterion(f"{name}, {stepper}: E >= truth", good / own, limit - WORSE, own))
    return found


def _share(values: list[Any], holds: Callable[[Any], bool]) -> float:
    return sum(map(holds, values)) / len(values) if values else 1.0


def _found(lines: list[Line]) -> list[str]:
    """Runs that are wrongly called Trusted, understate, or broke: by seed."""
    judged = [line for line in lines if line["outcome"] == "judged"]
    words = [f"Trusted and off by more than said and 2 %: {', '.join(failures(judged)) or 'none'}."]
    for line in judged:
        low = {name: r for name in MEASURES if (r := ratio(line, name)) is not None and r < 1.0}
        if low:
            told = ", ".join(f"{name} {value:.2f}" for name, value in low.items())
            words.append(
                f"- {line['dimension']}D seed {line['seed']}, {line['kind']}, {line['stepper']}: E/true {told}"
            )
    broken = [line for line in lines if line["outcome"] in ("broken", "not verified")]
    return words + [
        f"- {x['dimension']}D seed {x['seed']}, {x['stepper']}: {x['outcome']}: {x['said']}" for x in broken
    ]
