"""What a log of :mod:`tests.property.error_campaign` shows, and whether that is enough."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from tests.property.error_judge import MEASURES

__all__ = ["CRITERIA", "covered", "failures", "ratio", "summary", "understated"]

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
CRITERIA = "E >= truth in 95 % of places, 92 % of rotations, 90 % of velocities (off impacts, rms); half of it in 97 %"


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


def covered(lines: Iterable[Line], least: float, names: Iterable[str] = MEASURES) -> tuple[int, int]:
    """How many of how many ratios are ``least`` or more."""
    ratios = [r for line in lines for name in names if (r := ratio(line, name)) is not None]
    return sum(r >= least for r in ratios), len(ratios)


def understated(line: Line) -> list[str]:
    """The measures by which a run is off by more than it says and by more than 2 %."""
    found = []
    for name in MEASURES:
        true, size = line["true"][name], line["extent" if name in MEASURES[:2] else "fastest"]
        if true is not None and true > OFF * size and true > line["claimed"][name]:
            found.append(name)
    return found


def _right(line: Line) -> bool:
    sizes = {"place": line["extent"], "turn": line["extent"], "speed": line["fastest"]}
    return all(line["true"][name] <= OFF * size for name, size in sizes.items())


def _trusted(line: Line) -> bool:
    return str(line["verdict"]).startswith("Trusted")


def failures(lines: Iterable[Line]) -> list[str]:
    """The runs called Trusted that are off by more than they say and 2 %."""
    return [f"{line['dimension']}D seed {line['seed']}" for line in lines if _trusted(line) and understated(line)]


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
        f"Judged: runs off by {FLOOR:g} of the extent or of the largest speed, by measure ({', '.join(EXACTLY)}: "
        f"{EXACT:g}, the truth being the same method at 1e-12). {CRITERIA}; each stepper at most {WORSE:.0%} worse."
    ]
    for dimension in sorted({line["dimension"] for line in lines}):
        own = [line for line in lines if line["dimension"] == dimension]
        words += ["", _counts(NAMES[dimension], own), "", *_table(own)]
    judged = [line for line in lines if line["outcome"] == "judged"]
    return "\n".join([*words, "", "Both:", "", *_table(lines), "", *_criteria(judged), "", *_found(lines)])


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
    ratios = np.array([r for line in lines if (r := ratio(line, name, claim)) is not None])
    if not len(ratios):
        return "-"
    return f"{len(ratios)}: {np.median(ratios):.2f}, {(ratios >= 1.0).mean():.0%}, {(ratios >= 0.5).mean():.0%}"


def _criteria(judged: list[Line]) -> list[str]:
    words = []

    def tell(what: str, share: float, limit: float, count: int) -> None:
        ok = not share < limit
        words.append(f"- {what}: {share:.1%} of {count}, limit {limit:.0%}: {'passes' if ok else 'FAILS'}")

    for name, limit in LIMITS.items():
        good, count = covered(judged, 1.0, [name])
        tell(f"E >= truth, {name}", good / max(1, count), limit, count)
        for stepper in sorted({line["stepper"] for line in judged}):
            good, own = covered([line for line in judged if line["stepper"] == stepper], 1.0, [name])
            if own >= OFTEN and good / own < limit - WORSE:
                tell(f"    {stepper}, {name}", good / own, limit - WORSE, own)
        half, count = covered(judged, 0.5, [name])
        tell(f"E >= half the truth, {name}", half / max(1, count), HALF, count)
        ratios = [r for line in judged if (r := ratio(line, name)) is not None]
        median = float(np.median(ratios)) if ratios else 0.0
        words.append(f"- median, {name}: {median:.2f}, limit {MEDIAN}: {'passes' if median <= MEDIAN else 'FAILS'}")
    apart = _horizons(judged)
    tell("horizon no later than 1.1 x true", _share(apart, lambda r: r <= LATE), IN_TIME, len(apart))
    tell("horizon at least half the true one", _share(apart, lambda r: r >= EARLY), NOT_SOONER, len(apart))
    right = [line for line in judged if _right(line)]
    tell(
        "right runs not called wrong",
        _share(right, lambda line: not line["verdict"].startswith("NOT")),
        1 - FALSE,
        len(right),
    )
    return words


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
