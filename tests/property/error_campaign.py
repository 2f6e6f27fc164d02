"""How good measured errors are over random scenes of plane and space, as a command.

    python -m tests.property.error_campaign --dimension 2 --seeds 30000:30300 --log error2.jsonl   # resumed
    python -m tests.property.error_campaign --dimension 3 --seeds 30000:30300 --log error3.jsonl
    python -m tests.property.error_campaign --summary error2.jsonl error3.jsonl
    python -m tests.property.error_campaign --dimension 3 --one 30019                               # one seed

A log holds one JSON object a seed; seeds that are in it already are not run again.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterable
from pathlib import Path

from tests.property.campaign import read
from tests.property.error_judge import error_line
from tests.property.error_summary import summary
from tests.property.random_scenes import draw

__all__ = ["run"]


def run(dimension: int, seeds: Iterable[int], log: Path) -> None:
    """Judge the seeds that the log does not hold yet."""
    done = {line["seed"] for line in read([log]) if line["dimension"] == dimension} if log.exists() else set()
    with log.open("a", encoding="utf-8") as file:
        for seed in seeds:
            if seed in done:
                continue
            began = time.perf_counter()
            drawn = draw(dimension, seed)
            try:
                line = error_line(drawn)
            except Exception as error:  # a run that breaks is a finding like any other
                line = {"dimension": dimension, "seed": seed, "kind": drawn.kind, "stepper": drawn.stepper}
                line |= {"outcome": "broken", "said": f"{type(error).__name__}: {error}"[:400]}
            spent = time.perf_counter() - began
            file.write(json.dumps(line | {"spent": spent}) + "\n")
            file.flush()
            print(f"seed {seed}, {drawn.stepper}: {line['outcome']} in {spent:.0f} s", flush=True)


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--dimension", type=int, choices=[2, 3], default=2)
    parser.add_argument("--seeds", default="30000:30300", help="first:last, the last one left out")
    parser.add_argument("--log", type=Path, default=Path("error_campaign.jsonl"))
    parser.add_argument("--one", type=int, help="judge one seed and show its scene")
    parser.add_argument("--summary", type=Path, nargs="+", help="logs to sum up")
    options = parser.parse_args()
    if options.one is not None:
        drawn = draw(options.dimension, options.one)
        print(drawn)
        print(json.dumps(error_line(drawn), indent=1))
    elif options.summary:
        print(summary(read(options.summary)))
    else:
        run(options.dimension, range(*map(int, options.seeds.split(":"))), options.log)


if __name__ == "__main__":
    main()
