"""Work against precision: which method is the cheapest for the accuracy that is asked for?

It depends on the scene, and on the accuracy. Three of them, in ``work_precision_scenes.png``:

An elastic bar of 100 elements hits a wall and leaves it after the time of a wave; the impulse is known exactly.
Below a step of about 3 ms nothing is gained: what is left, 0.6 %, is the error of the mesh, by any method.

A flexible pendulum meets a rough stop: a long smooth fall, then impacts. No exact solution is known; an event-driven
run with tight tolerances stands in for it, and a second one, less tight, tells how far the first can be trusted: in
the grey band nothing is claimed.

Three boxes stand on each other and the lowest one is pushed: friction in every face, until all of it rests.

Two pictures are of one scene each, a block that sticks and slips and a billiard ball in space, by four methods: error
against time, and beside it what every run says of its own error, by reruns of it, against what it is off by. Above
the diagonal it says enough.

Velocities jump. At equal times a jump that comes a moment too early is as wrong as it is high, so that no method
would ever converge; errors are therefore distances of graphs, in which the jump costs its delay.
"""

from pathlib import Path

import lcpflex as lf
from lcpflex import gallery
from lcpflex.runs.simulate import Stepper
from lcpflex.studies import WorkPrecision, work_precision

CONTACT = (0.5, 0.5 + 2.0 / 3.0)  # of the bar of the gallery: it touches, the wave comes back
LIMIT = 0.2  # wall time of a run [s]


def pushed_stack() -> lf.Scene:
    """Three boxes, the lowest one pushed at 1 m/s."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    for k in range(3):
        box = lf.Box(width=0.4, height=0.1, mass=1.0)
        scene.add(box, name=f"box {k + 1}", position=(0.0, 0.05 + 0.1 * k), velocity=(float(k == 0), 0.0))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact_all(friction=0.4)
    return scene


def series(duration: float) -> dict[str, list[Stepper]]:
    """Steps and tolerances from coarse to fine."""
    return {
        "Moreau-Jean": [lf.MoreauJean(step=duration / 50 / 3**k) for k in range(7)],
        "Moreau-Jean, adaptive": [
            lf.MoreauJean(step=1e-3 * duration, adaptive=lf.AdaptiveStep(rtol=r, atol=0.1 * r, shortest=1e-2 * r))
            for r in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
        ],
        "generalised-alpha": [lf.GeneralizedAlpha(step=duration / 50 / 3**k) for k in range(7)],
        "event-driven": [lf.EventDriven(rtol=r, atol=0.1 * r) for r in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)],
    }


def of_one_scene(name: str) -> WorkPrecision:
    """Four methods on a case of the gallery, with the errors that they claim."""
    case = gallery.scenes()[name]
    duration = case.duration
    methods: dict[str, list[Stepper]] = {
        "Moreau-Jean": [lf.MoreauJean(step=duration / 100 / 3**k) for k in range(5)],
        "generalised-alpha": [lf.GeneralizedAlpha(step=duration / 100 / 3**k) for k in range(5)],
        "Moreau-Jean, adaptive": [
            lf.MoreauJean(step=1e-3 * duration, adaptive=lf.AdaptiveStep(rtol=r, atol=0.1 * r, shortest=1e-2 * r))
            for r in (1e-4, 1e-5, 1e-6, 1e-7)
        ],
        "event-driven": [lf.EventDriven(rtol=r, atol=0.1 * r) for r in (1e-2, 1e-4, 1e-6)],
    }
    exact = lf.EventDriven(rtol=1e-11, atol=1e-13)
    return work_precision({name.replace("_", " "): case.build}, methods, exact, outputs="motion", duration=duration,
                          limit=LIMIT, claims=True)  # fmt: skip


def run(folder: Path = Path()) -> lf.Result:
    bar = work_precision(
        {"elastic bar, 100 elements": lambda: gallery.elastic_bar(elements=100)},
        series(1.5) | {"massless boundary": [lf.MasslessBoundary(step=0.03 / 3**k) for k in range(7)]},
        {"impulse": lambda t: 300.0 * (t.clip(*CONTACT) - CONTACT[0])},
        outputs={"impulse": lambda result: result.impulse[:, 0, 0]},
        duration=1.5,
        repeats=1,
        limit=LIMIT,
    )
    fine = lf.EventDriven(rtol=1e-9, atol=1e-11)
    pendulum = work_precision({"flexible pendulum": gallery.pendulum}, series(0.5), fine, duration=0.5, repeats=1,
                              limit=LIMIT, outputs=["trajectory"], modes=[4])  # fmt: skip
    stack = work_precision({"pushed stack": pushed_stack}, series(0.5), fine, duration=0.5, repeats=1, limit=LIMIT,
                           outputs=["trajectory"])  # fmt: skip
    work = bar + pendulum + stack
    print(work.advice())

    best = work.cheapest(1e-2, scene="elastic bar, 100 elements")
    assert best is not None
    assert best.errors["impulse"] < 1e-2

    work.plot().savefig(folder / "work_precision_scenes.png", dpi=150)
    for name, picture in (("stick_slip", "work_precision"), ("billiard_ball", "work_precision_in_space")):
        one = of_one_scene(name)
        print(one)
        one.plot(panels=("error", "claimed")).savefig(folder / f"{picture}.png", dpi=150)
    return lf.simulate(pushed_stack(), 0.5, lf.MoreauJean(step=1e-3))


if __name__ == "__main__":
    print(run().summary())
