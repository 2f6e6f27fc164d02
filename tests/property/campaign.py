"""The property campaign over random scenes of plane and space as a command.

    python -m tests.property.campaign --dimension 2 --seeds 0:500 --log plane.jsonl   # resumed where the log ends
    python -m tests.property.campaign --dimension 3 --seeds 0:500 --log space.jsonl
    python -m tests.property.campaign --summary plane.jsonl space.jsonl               # the text for ACCURACY.md
    python -m tests.property.campaign --dimension 3 --one 19                          # one seed, with its scene

A log holds one JSON object a seed; seeds that are in it already are not run again, so that a run can be stopped and
resumed. ``--summary ... --write`` puts the text into ``lcpflex/ACCURACY.md``.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lcpflex.gallery.acceptance.table import CAMPAIGN
from tests.property.judge import JUDGED, OFF, RIGHT, alarms, judge, quiet, stops
from tests.property.random_scenes import draw
from tests.property.truths import AGREED, LEAST

__all__ = ["passes", "read", "run", "summary"]

ENOUGH = 300  # judged scenes of each dimension of a whole campaign
MOST_ALARMS = 0.02  # share of false alarms among the runs that are right, and of errors among those with a truth
QUIET = 0.75  # share of the right runs that must have no warning
NAMES = {2: "plane", 3: "space"}
COLUMNS = {
    "quiet": "right without a word",
    "warned": "right with a warning",
    "alarm": "right, called not to be trusted",
    "stopped": "stopped",
    "stated": "off, stated",
    "loud": "off, loud",
    "hinted": "off, with a warning",
    "understated": "off by more than stated",
    "silent": "off, silent",
}


def run(dimension: int, seeds: Iterable[int], log: Path) -> None:
    """Judge the seeds that the log does not hold yet."""
    done = {line["seed"] for line in read([log]) if line["dimension"] == dimension} if log.exists() else set()
    counts: Counter[str] = Counter()
    began = time.perf_counter()
    todo = [seed for seed in seeds if seed not in done]
    with log.open("a", encoding="utf-8") as file:
        for number, seed in enumerate(todo, 1):
            try:
                line = judge(draw(dimension, seed)).line()
            except Exception as error:  # a run that breaks is a finding like any other
                line = {"dimension": dimension, "seed": seed, "kind": draw(dimension, seed).kind, "outcome": "broken"}
                line["said"] = f"{type(error).__name__}: {error}"[:400]
            counts[line["outcome"]] += 1
            file.write(json.dumps(line) + "\n")
            file.flush()
            if line["outcome"] in ("silent", "broken", "alarm", "hinted", "understated"):
                print(f"seed {seed}: {line}", flush=True)
            if number % 10 == 0 or number == len(todo):
                spent = time.perf_counter() - began
                print(f"{number}/{len(todo)} in {spent:.0f} s: {dict(counts)}", flush=True)


def read(logs: Iterable[Path]) -> list[dict[str, Any]]:
    """All lines of the logs, by dimension and seed."""
    lines = [json.loads(text) for log in logs for text in log.read_text(encoding="utf-8").splitlines() if text]
    found = {(line["dimension"], line["seed"]): line for line in lines}
    return [found[key] for key in sorted(found)]


def passes(counts: Counter[str]) -> bool:
    """Whether a whole campaign in one dimension shows what it must."""
    judged = sum(counts[name] for name in JUDGED)
    clean = not counts["silent"] and not counts["broken"]
    few = max(alarms(counts), stops(counts)) <= MOST_ALARMS
    return judged >= ENOUGH and clean and few and quiet(counts) >= QUIET


def summary(lines: list[dict[str, Any]]) -> str:
    """Counts and shares, for each dimension in all and by stepper and kind, and the seeds of what is wrong."""
    words = [
        f"A truth of at least {LEAST:g} s: up to where event-driven stepping at 1e-12 and another method differ by "
        f"{AGREED:.1%} of the size. Off: places, or velocities off impacts, by more than {OFF:.0%} of the size or the "
        "largest speed, or through something; stated: by no more than the run says."
    ]
    for dimension in sorted({line["dimension"] for line in lines}):
        words += _of_dimension(NAMES[dimension], [line for line in lines if line["dimension"] == dimension])
    return "\n".join(words)


def _of_dimension(name: str, lines: list[dict[str, Any]]) -> list[str]:
    counts = Counter(line["outcome"] for line in lines)
    judged, right = (sum(counts[outcome] for outcome in every) for every in (JUDGED, RIGHT))
    seeds = [line["seed"] for line in lines]
    words = [
        "",
        f"In {name}, seeds {min(seeds)} to {max(seeds)}: {len(lines)} scenes, {judged} with a truth; "
        f"{counts['silent']} silent, {alarms(counts):.1%} false alarms, {stops(counts):.1%} stopped by an error; of "
        f"the {right} that are right {quiet(counts):.0%} have no warning: "
        f"{'passes' if passes(counts) else 'does not pass'}. "
        f"{counts['no truth']} have no truth, {counts['refused']} were refused, {counts['slow']} took too long.",
        "",
        f"| {name} | judged | {' | '.join(COLUMNS.values())} |",
        "|---" * (len(COLUMNS) + 2) + "|",
    ]
    for label in (_stepper, lambda line: str(line.get("kind"))):
        for value in sorted({label(line) for line in lines if line["outcome"] in JUDGED}):
            own = Counter(line["outcome"] for line in lines if label(line) == value)
            cells = [sum(own[k] for k in JUDGED), *(own[k] for k in COLUMNS)]
            words.append(f"| {value} | {' | '.join(map(str, cells))} |")
    for outcome in ("silent", "broken", "understated", "hinted", "alarm", "stopped"):
        if counts[outcome]:
            found = [str(line["seed"]) for line in lines if line["outcome"] == outcome]
            words += ["", f"{outcome.capitalize()}: seeds {', '.join(found)}."]
    return words


def _stepper(line: dict[str, Any]) -> str:
    """Stepper of a log line, without its numbers."""
    text = str(line.get("stepper", ""))
    name = text.split("(")[0]
    if name == "Smooth":
        name += ", " + text.split("integrator=")[1].split("(")[0]
    return name + (", adaptive" if "AdaptiveStep(" in text else "")


def write(text: str) -> None:
    """Put the summary into ACCURACY.md, in the place of an older one; what stands behind that is kept."""
    import lcpflex

    path = Path(lcpflex.__file__).parent / "ACCURACY.md"
    before, _, older = path.read_text(encoding="utf-8").partition(CAMPAIGN)
    _, found, behind = older.partition("\n## ")
    path.write_text(f"{before.rstrip()}\n\n{CAMPAIGN}\n\n{text}\n{found}{behind}", encoding="utf-8")


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--dimension", type=int, choices=sorted(NAMES), default=2)
    parser.add_argument("--seeds", default="0:500", help="first:last, the last one left out")
    parser.add_argument("--log", type=Path, default=Path("campaign.jsonl"))
    parser.add_argument("--one", type=int, help="judge one seed and show its scene")
    parser.add_argument("--summary", type=Path, nargs="+", help="logs to sum up")
    parser.add_argument("--write", action="store_true", help="put the summary into ACCURACY.md")
    options = parser.parse_args()
    if options.one is not None:
        drawn = draw(options.dimension, options.one)
        print(drawn)
        print(json.dumps(judge(drawn).line(), indent=1))
    elif options.summary:
        text = summary(read(options.summary))
        print(text)
        if options.write:
            write(text)
    else:
        run(options.dimension, range(*map(int, options.seeds.split(":"))), options.log)


if __name__ == "__main__":
    main()
