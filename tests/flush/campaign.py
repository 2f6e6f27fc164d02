"""The campaign over random scenes of flat bodies as a command.

python -m tests.flush.campaign --seeds 0:400 --log flush.jsonl   # resumed where the log ends
python -m tests.flush.campaign --summary flush.jsonl
python -m tests.flush.campaign --one 19                          # one seed, with its scene
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tests.flush.random_scenes import draw
from tests.flush.verdicts import JUDGED, LEAST, false_alarms, judge
from tests.property.campaign import read, run

__all__ = ["ENOUGH", "MOST_ALARMS", "passes", "summary"]

ENOUGH = 200  # judged scenes of a whole campaign
MOST_ALARMS = 0.02  # share of false alarms


def passes(lines: Iterable[dict[str, Any]]) -> bool:
    """Whether a whole campaign shows what it must."""
    outcomes = [str(line["outcome"]) for line in lines]
    judged = [name for name in outcomes if name in JUDGED]
    bad = {"silent", "broken"} & set(outcomes)
    return len(judged) >= ENOUGH and not bad and false_alarms(judged) <= MOST_ALARMS


def summary(lines: list[dict[str, Any]]) -> str:
    """Counts, in all and by stepper, and the seeds of what is wrong."""
    counts = Counter(str(line["outcome"]) for line in lines)
    judged = [line for line in lines if line["outcome"] in JUDGED]
    words = [
        f"{len(lines)} scenes, {len(judged)} with at least {LEAST:g} s of truth, or a body in another one: "
        f"{counts['silent']} silent, {false_alarms([line['outcome'] for line in judged]):.1%} false alarms; "
        f"{'passes' if passes(lines) else 'does not pass'}."
    ]
    for name in sorted({str(line.get("stepper")) for line in judged}):
        words.append(f"{name}: {dict(Counter(line['outcome'] for line in judged if line.get('stepper') == name))}")
    for outcome in ("silent", "broken", "loud", "stopped", "alarm"):
        found = [str(line["seed"]) for line in lines if line["outcome"] == outcome]
        if found:
            words.append(f"{outcome}: seeds {', '.join(found)}")
    return "\n".join(words)


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0:400", help="first:last, the last one left out")
    parser.add_argument("--log", type=Path, default=Path("flush.jsonl"))
    parser.add_argument("--one", type=int, help="judge one seed and show its scene")
    parser.add_argument("--summary", type=Path, nargs="+", help="logs to sum up")
    options = parser.parse_args()
    if options.one is not None:
        print(draw(options.one))
        print(json.dumps(judge(options.one).line(), indent=1))
    elif options.summary:
        print(summary(read(options.summary)))
    else:
        run(range(*map(int, options.seeds.split(":"))), options.log, lambda seed: judge(seed).line())


if __name__ == "__main__":
    main()
