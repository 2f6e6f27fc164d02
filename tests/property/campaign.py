"""The property campaign over random scenes as a command.

    python -m tests.property.campaign --seeds 0:1200 --part 0/2 --log campaign0.jsonl   # one of two processes
    python -m tests.property.campaign --seeds 0:1200 --part 1/2 --log campaign1.jsonl
    python -m tests.property.campaign --summary campaign0.jsonl campaign1.jsonl         # the text for ACCURACY.md
    python -m tests.property.campaign --one 19                                          # one seed, with its scene

A log holds one JSON object a seed; seeds that are in it already are not run again, so that a run can be stopped and
resumed. ``--summary ... --write`` puts the text into ``lcpflex/ACCURACY.md``.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from lcpflex.gallery.acceptance.table import CAMPAIGN
from tests.property.judge import AGREED, LEAST, OFF, TIMES, judge
from tests.property.random_scenes import draw

__all__ = ["JUDGED", "RIGHT", "passes", "quiet_share", "read", "run", "summary"]

RIGHT = ("quiet", "warned")
JUDGED = (*RIGHT, "silent", "loud", "stated")
ENOUGH = 500  # judged scenes of a whole campaign
QUIET = 0.7  # share of the right runs that must have no warning


def run(seeds: Iterable[int], log: Path, judged: Callable[[int], dict[str, Any]] | None = None) -> None:
    """Judge the seeds that the log does not hold yet; ``judged``: another judge, which gives a line for the log."""
    judged = judged or (lambda seed: judge(draw(seed)).line())
    done = {line["seed"] for line in read([log])} if log.exists() else set()
    counts: Counter[str] = Counter()
    began = time.perf_counter()
    todo = [seed for seed in seeds if seed not in done]
    with log.open("a", encoding="utf-8") as file:
        for number, seed in enumerate(todo, 1):
            try:
                line = judged(seed)
            except Exception as error:  # a run that breaks is a finding like any other
                line = {"seed": seed, "outcome": "broken", "said": f"{type(error).__name__}: {error}"[:400]}
            counts[line["outcome"]] += 1
            file.write(json.dumps(line) + "\n")
            file.flush()
            if line["outcome"] in ("silent", "broken"):
                print(f"seed {seed}: {line}", flush=True)
            if number % 10 == 0 or number == len(todo):
                spent = time.perf_counter() - began
                print(f"{number}/{len(todo)} in {spent:.0f} s: {dict(counts)}", flush=True)


def read(logs: Iterable[Path]) -> list[dict[str, Any]]:
    """All lines of the logs, by seed."""
    lines = [json.loads(text) for log in logs for text in log.read_text(encoding="utf-8").splitlines() if text]
    return sorted({line["seed"]: line for line in lines}.values(), key=lambda line: int(line["seed"]))


def quiet_share(counts: Counter[str]) -> float:
    """Of the runs that are right, those without a warning."""
    right = counts["quiet"] + counts["warned"]
    return counts["quiet"] / right if right else 1.0


def passes(counts: Counter[str]) -> bool:
    """Whether a whole campaign shows what it must."""
    judged = sum(counts[name] for name in JUDGED)
    return judged >= ENOUGH and not counts["silent"] and not counts["broken"] and quiet_share(counts) >= QUIET


def summary(lines: list[dict[str, Any]]) -> str:
    """Counts and shares, in all and by stepper, and the seeds of what is wrong."""
    counts = Counter(line["outcome"] for line in lines)
    judged = sum(counts[name] for name in JUDGED)
    seeds = [line["seed"] for line in lines]
    words = [
        f"Seeds {min(seeds)} to {max(seeds)}, {len(lines)} scenes: {judged} have a truth of at least {LEAST:g} s, up "
        f"to where two references of other methods, ten and twenty times finer, differ by {AGREED:.1%} of the size; "
        f"{counts['no truth']} have none, {counts['refused']} were refused, {counts['stopped']} stopped with an error.",
        "",
        f'Of the judged ones {counts["silent"]} are silent: say "can be trusted", have no warning, and have passed '
        f"through something or are off by more than {OFF:.0%} and more than {TIMES:g} times the error of the steps "
        f"that they state. {counts['quiet'] + counts['warned']} are within {OFF:.0%}, of which {counts['quiet']} "
        f"({quiet_share(counts):.0%}) have no warning; {counts['loud']} are off and say so, {counts['stated']} are off "
        "within what they state.",
        "",
        "| stepper | judged | within 2 % without a warning | with one | off, stated | off, loud | silent |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in sorted({_name(line) for line in lines if line["outcome"] in JUDGED}):
        own = Counter(line["outcome"] for line in lines if line.get("stepper") and _name(line) == name)
        cells = [sum(own[k] for k in JUDGED), *(own[k] for k in ("quiet", "warned", "stated", "loud", "silent"))]
        words.append(f"| {name} | {' | '.join(map(str, cells))} |")
    for outcome in ("silent", "broken"):
        if counts[outcome]:
            found = [str(line["seed"]) for line in lines if line["outcome"] == outcome]
            words += ["", f"{outcome.capitalize()}: seeds {', '.join(found)}."]
    return "\n".join(words)


def _name(line: dict[str, Any]) -> str:
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
    parser.add_argument("--seeds", default="0:1200", help="first:last, the last one left out")
    parser.add_argument("--part", default="0/1", help="k/n: each n-th seed, from the k-th one on")
    parser.add_argument("--log", type=Path, default=Path("campaign.jsonl"))
    parser.add_argument("--one", type=int, help="judge one seed and show its scene")
    parser.add_argument("--summary", type=Path, nargs="+", help="logs to sum up")
    parser.add_argument("--write", action="store_true", help="put the summary into ACCURACY.md")
    options = parser.parse_args()
    if options.one is not None:
        print(draw(options.one))
        print(json.dumps(judge(draw(options.one)).line(), indent=1))
    elif options.summary:
        text = summary(read(options.summary))
        print(text)
        if options.write:
            write(text)
    else:
        first, last = map(int, options.seeds.split(":"))
        part, of = map(int, options.part.split("/"))
        run(range(first + part, last, of), options.log)


if __name__ == "__main__":
    main()
