"""Makes a run of one scene for each line of input, and prints the seconds of processor time that a step has taken."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import lcpflex as lf
from lcpflex import gallery

SCENES: dict[str, tuple[Callable[[], lf.Scene], float, object]] = {
    "pendulum": (gallery.pendulum, 0.6, lf.MoreauJean(step=1e-5)),
    "incline": (gallery.block_on_incline, 1.0, lf.MoreauJean(step=2e-5)),
    "bar": (lambda: gallery.elastic_bar(elements=30), 1.5, lf.MoreauJean(step=1e-4)),
    "event_driven": (gallery.stick_slip_block, 1.9, lf.EventDriven(max_step=1e-3)),
    "generalized_alpha": (gallery.pendulum, 0.6, lf.GeneralizedAlpha(step=2e-5)),
}


def main() -> None:
    build, duration, stepper = SCENES[sys.argv[1]]
    lf.simulate(build(), duration, stepper, record=duration, progress=False)
    for _ in sys.stdin:
        scene = build()
        began = time.process_time()
        result = lf.simulate(scene, duration, stepper, record=duration, progress=False)
        print((time.process_time() - began) / result.steps, flush=True)


main()
