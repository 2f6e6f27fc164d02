"""Runs to a tolerance over scenes and tolerances: claimed against true errors, and what they cost, as a command.

    python -m tests.property.tolerance_campaign --log tolerance.jsonl            # resumed where the log ends
    python -m tests.property.tolerance_campaign --summary tolerance.jsonl
    python -m tests.property.tolerance_campaign --one graze --tolerance .001     # one request, with its choice

Truth is event-driven stepping at a tolerance of 1e-12, as far as one of 1e-10 agrees with it; where it does not come to
the end, Moreau-Jean and generalised-alpha with steps of 1/64,000 of the duration. Of bodies with modes it has all
of their meshes. What the two truths are apart is counted as unknown.
"""

from __future__ import annotations

import argparse
import json
import math
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import lcpflex as lf
from lcpflex.accuracy.apart import apart
from lcpflex.accuracy.comparison import bodies_of, grid_of, sizes_of
from lcpflex.accuracy.richer import richer
from lcpflex.accuracy.trials import START, STEP_COSTS, USUAL
from lcpflex.runs.default_stepper import explicit_steps
from tests.property.tolerance_scenes import SCENES, Asked, by_name

__all__ = ["TOLERANCES", "judge", "requests", "summary"]

TOLERANCES = (0.1, 0.01, 0.001)
FINEST = 64_000  # steps of a truth by fixed steps
LADDER = tuple(125 * 2**k for k in range(9))  # steps of the runs that a request is compared with
RTOLS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
SLOW = 0.5  # [s]: finer runs of a method that takes as long cost more than is looked for
PATIENCE = 8.0  # [s] for a truth
MOST_EXPLICIT = 1e4  # steps for the fastest mode, from where on event-driven stepping comes to no end in time
MORE = 2.0**20  # times as many modes has the truth: all of its meshes


def requests() -> Iterator[tuple[Asked, float]]:
    """All of them."""
    for scene in SCENES:
        for tolerance in TOLERANCES:
            yield scene, tolerance


def judge(asked: Asked, tolerance: float, known: dict[str, Any], costs: bool = True) -> dict[str, Any]:
    """What comes of a request; ``known``: truth and ladder of its scene, filled at the first; ``costs``: with these."""
    line: dict[str, Any] = {"scene": asked.name, "kind": asked.kind, "tolerance": tolerance}
    began = time.perf_counter()
    try:
        result = lf.simulate(asked.build(), asked.duration, tolerance=tolerance, progress=False)
    except lf.ToleranceError as error:
        choice = error.result.choice if error.result is not None else None
        line |= {"outcome": "refused", "why": str(error), "work": 0.0 if choice is None else choice.work}
        return line | {"seconds": time.perf_counter() - began}
    seconds = time.perf_counter() - began
    if costs and seconds < 2.0:  # once more, with all kernels loaded
        began = time.perf_counter()
        lf.simulate(asked.build(), asked.duration, tolerance=tolerance, progress=False)
        seconds = time.perf_counter() - began
    choice = result.choice
    line |= {"outcome": "answered", "claimed": choice.claimed, "work": choice.work, "seconds": seconds}
    line |= {"stepper": choice.trials[choice.chosen - 1].stepper, "modes": choice.modes_tried, "why": choice.why}
    line |= {"confirmed": choice.confirmed, "verdict": result.verdict.word, "warned": len(result.warnings)}
    truth, unknown, said = _truth(asked, known)
    if truth is None:
        return line | {"true": None, "truth": said}
    line |= {"true": off(result, truth), "unknown": unknown, "truth": said}
    cheapest = [run for run in _ladder(asked, known, truth) if run["off"] <= tolerance] if costs else []
    if cheapest:
        line |= {"cheapest": min(run["work"] for run in cheapest), "quickest": min(run["took"] for run in cheapest)}
    return line


def off(result: lf.Result, truth: lf.Result) -> float:
    """Largest distance of a run from the truth, of the worst point of a body, over the extent or travel."""
    if result.compiled is None:
        at = np.linspace(0.0, float(result.times[-1]), 1001)
        ours, theirs = (np.array([np.interp(at, r.times, column) for column in r.q.T]) for r in (result, truth))
        return float((np.abs(ours - theirs).max(axis=1) / np.maximum(np.ptp(theirs, axis=1), 1e-12)).max())
    found = apart(result, truth, np.unique(result.times[grid_of(result, float(truth.times[-1]))]))
    return float((found.place + found.turn).max(initial=0.0)) / sizes_of(truth, bodies_of(truth))[0]


def _run(scene: Any, duration: float, stepper: Any, seconds: float = PATIENCE) -> lf.Result | None:
    """A run that came to its end in time."""
    try:
        found = lf.simulate(scene, duration, stepper, progress=False, budget=seconds, record=duration / 2000)
    except lf.LcpflexError:
        return None
    return found if found.complete and np.isfinite(found.q).all() else None


def _truth(asked: Asked, known: dict[str, Any]) -> tuple[lf.Result | None, float, str]:
    if "truth" not in known:
        known["truth"] = _truths(asked)
    found: tuple[lf.Result | None, float, str] = known["truth"]
    return found


def _truths(asked: Asked) -> tuple[lf.Result | None, float, str]:
    """The truth, by how much it is unknown, and what it is."""
    scene = asked.build()
    if not isinstance(scene, lf.UserSystem):
        scene = richer(scene, MORE)[0]
    pairs = (
        ("event-driven", [lf.EventDriven(rtol=1e-12), lf.EventDriven(rtol=1e-10)]),
        ("event-driven, less tight", [lf.EventDriven(rtol=1e-9), lf.EventDriven(rtol=1e-7)]),
        *(
            (f"{count} steps", [kind(step=asked.duration / count) for kind in (lf.GeneralizedAlpha, lf.MoreauJean)])
            for count in (FINEST, FINEST // 4)
        ),
    )
    source = scene if isinstance(scene, lf.UserSystem) else scene.compiled(project=True)
    slow = explicit_steps(source, asked.duration) > MOST_EXPLICIT
    for name, steppers in pairs[2:] if slow else pairs:
        first = _run(scene, asked.duration, steppers[0])
        second = None if first is None else _run(scene, asked.duration, steppers[1])
        if first is not None and second is not None:
            return first, off(second, first), name
    return None, math.nan, "none"


def _ladder(asked: Asked, known: dict[str, Any], truth: lf.Result) -> list[dict[str, float]]:
    """Runs of the scene, with how far each is off and what it costs."""
    if "ladder" in known:
        found: list[dict[str, float]] = known["ladder"]
        return found
    scene = asked.build()
    scenes = [scene]
    if asked.kind == "modes":
        scenes += [made for k in (0.5, 2.0) if (made := richer(scene, k, 2)[0]) is not scene]
    found = []
    size = 0.0
    for made in scenes:
        flexible = asked.kind == "modes"  # which take their time
        methods: list[Any] = [lf.EventDriven(rtol=rtol) for rtol in (RTOLS[::2] if flexible else RTOLS)]
        steps = LADDER[::2] if flexible else LADDER
        methods += [kind(step=asked.duration / n) for kind in (lf.GeneralizedAlpha, lf.MoreauJean) for n in steps]
        slow = set()
        for stepper in methods:
            name = type(stepper).__name__
            if name in slow:
                continue
            began = time.perf_counter()
            run = _run(asked.build() if made is scene else made, asked.duration, stepper, 2.0 * SLOW)
            took = time.perf_counter() - began
            if took < SLOW:  # kernels are loaded then
                began = time.perf_counter()
                run = _run(asked.build() if made is scene else made, asked.duration, stepper)
                took = min(took, time.perf_counter() - began)
            if took > SLOW:
                slow.add(name)
            if run is None:
                continue
            cost = STEP_COSTS[name] * (USUAL + run.u.shape[1])
            size = size or float(USUAL + run.u.shape[1])
            work = START + (run.steps + len(run.events)) * cost / size
            found.append({"off": off(run, truth), "work": work, "took": took})
    known["ladder"] = found
    return found


def read(log: Path) -> list[dict[str, Any]]:
    """The lines of a log."""
    return [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()] if log.exists() else []


def run(log: Path, seconds: float = math.inf) -> None:
    """Judge what the log does not hold yet, for at most so many seconds."""
    done = {(line["scene"], line["tolerance"]) for line in read(log)}
    began = time.perf_counter()
    known: dict[str, dict[str, Any]] = {}
    with log.open("a", encoding="utf-8") as file:
        for asked, tolerance in requests():
            if (asked.name, tolerance) in done or time.perf_counter() - began > seconds:
                continue
            known = {asked.name: known.get(asked.name, {})}
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    line = judge(asked, tolerance, known[asked.name])
            except Exception as error:  # what breaks is a finding like any other
                line = {"scene": asked.name, "kind": asked.kind, "tolerance": tolerance, "outcome": "broken"}
                line["why"] = f"{type(error).__name__}: {error}"[:400]
            file.write(json.dumps(line) + "\n")
            file.flush()
            print(
                f"{asked.name} {tolerance:g}: {line['outcome']} {line.get('claimed', line.get('why', ''))}", flush=True
            )


def summary(lines: list[dict[str, Any]]) -> str:
    """What came of all requests, in words."""
    answered = [line for line in lines if line["outcome"] == "answered"]
    known = [line for line in answered if line["true"] is not None]
    below = [line for line in known if line["true"] > line["claimed"] + line["unknown"]]
    far = [line for line in known if line["true"] > 3.0 * line["claimed"] + line["unknown"]]
    over = [line for line in answered if line["claimed"] > line["tolerance"]]
    refused = [line for line in lines if line["outcome"] == "refused"]
    broken = [line for line in lines if line["outcome"] == "broken"]
    found = [
        f"{len(lines)} requests: {len(answered)} answered, {len(refused)} refused, {len(broken)} broken",
        f"of {len(known)} with a truth: true error above the claim in {len(below)}, above three times it in "
        f"{len(far)}; claims above the tolerance: {len(over)}",
        f"with modes among what was chosen: {sum(len(line['modes']) > 1 for line in answered)}",
        *_costs("work", "cheapest", known),
        *_costs("seconds", "quickest", known),
        *(f"  below: {_named(line)}: true {line['true']:.2g} (unknown {line['unknown']:.2g})" for line in below),
        *(f"  refused: {_named(line)}: {line['why']}" for line in refused),
        *(f"  broken: {_named(line)}: {line['why']}" for line in broken),
        *(f"  not trusted: {_named(line)}" for line in answered if line["verdict"] != "Trusted"),
    ]
    return "\n".join(found)


def _named(line: dict[str, Any]) -> str:
    claimed = f", claimed {line['claimed']:.2g} by {line['stepper']}" if "claimed" in line else ""
    return f"{line['scene']} {line['tolerance']:g}{claimed}"


def _costs(own: str, other: str, lines: list[dict[str, Any]]) -> Iterator[str]:
    """Cost over that of the cheapest run within the tolerance."""
    shares = np.array([line[own] / max(line[other], 1e-12) for line in lines if other in line])
    if len(shares):
        marks = np.percentile(shares, [50, 75, 90, 100])
        told = f"median {marks[0]:.1f}, three quarters {marks[1]:.1f}, nine tenths {marks[2]:.1f}, worst {marks[3]:.0f}"
        yield f"{own} over those of the {other} run within the tolerance ({len(shares)}): {told}"


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--log", type=Path, default=Path("tolerance.jsonl"))
    parser.add_argument("--seconds", type=float, default=math.inf, help="after which no request is begun")
    parser.add_argument("--one", help="judge one scene and show what was tried")
    parser.add_argument("--tolerance", type=float, default=0.01, help="of --one")
    parser.add_argument("--summary", type=Path, help="a log to sum up")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(judge(by_name(options.one), options.tolerance, {}), indent=1))
        try:
            asked = by_name(options.one)
            print(lf.simulate(asked.build(), asked.duration, tolerance=options.tolerance, progress=False).choice)
        except lf.ToleranceError as error:
            print(error.result and error.result.choice)
    elif options.summary:
        print(summary(read(options.summary)))
    else:
        run(options.log, options.seconds)


if __name__ == "__main__":
    main()
