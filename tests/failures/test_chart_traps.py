"""Scenes on which a chart must refuse to promise, and words that must not be said; sound scenes still get advice.

A method that misses something does so at every tolerance, and agrees with itself to the last digit. ``Misses`` is such
a method by construction: event-driven steps, on the scene as it sees it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.errors import ModelError
from lcpflex.studies import Output, WorkPrecision, work_precision as full_study
from tests.scenes import floor_of, grazing_disc

EVENTS = [lf.EventDriven(rtol=r, atol=0.1 * r) for r in (1e-5, 1e-6, 1e-7)]


work_precision = partial(full_study, instants=4000)  # enough, and quick


def moreau(duration: float, *counts: int) -> list[lf.MoreauJean]:
    return [lf.MoreauJean(step=duration / n) for n in counts or (300, 900, 2700)]


def alpha(duration: float, *counts: int) -> list[lf.GeneralizedAlpha]:
    return [lf.GeneralizedAlpha(step=duration / n) for n in counts or (300, 900, 2700)]


@dataclass(frozen=True)
class Misses:
    """A stepper that runs the scene as it sees it, to a tolerance."""

    rtol: float
    seen: Callable[[], lf.Scene]

    def start(self, system: Any, duration: float, interval: float) -> Any:
        other = self.seen().compiled().system()
        return lf.EventDriven(rtol=self.rtol, atol=0.1 * self.rtol).start(
            replace(other, functions=system.functions), duration, interval
        )


@dataclass(frozen=True)
class MissesToo(Misses):
    """The same mistake under another name."""


def blind(seen: Callable[[], lf.Scene], kind: type[Misses] = Misses) -> list[Misses]:
    """One that is as sure of itself as can be, at nine tolerances."""
    return [kind(10.0**-k, seen) for k in range(2, 11)]


def graze(aside: float = 0.0) -> lf.Scene:
    """A disc passes another, which it overlaps by 2 mm on its way, and is deflected."""
    return grazing_disc(2e-3, aside)


def pulse(force: float = 100.0) -> lf.Scene:
    """A box on rough ground is pushed for 50 ms."""
    scene = lf.Scene()
    box = scene.add(lf.Box(0.4, 0.2, mass=1.0), name="box", position=(0.0, 0.1), velocity=(1.0, 0.0))
    scene.contact(box.surface(), floor_of(scene), friction=0.3)
    push = lf.Table([0.0, 0.3, 0.325, 0.35, 10.0], [0.0, 0.0, force, 0.0, 0.0])
    scene.load(lf.Force(box.point("center"), (push, 0.0)))
    return scene


def lift(friction: float = 0.3, catch: float = 0.25) -> lf.Scene:
    """A ball thrown upwards meets a ceiling, softly."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    ball = scene.add(lf.Disc(0.05, mass=1.0), name="ball", position=(0.0, 0.05), velocity=(0.3, 2.0))
    scene.contact(ball.surface(), scene.ground.half_plane((0.0, catch), (0.0, -1.0)), restitution=0.3)
    return scene


MISSED = {
    "a graze": (graze, lambda: graze(aside=1.0), 1.0),
    "a pulse of a load": (pulse, lambda: pulse(0.0), 0.6),
    "a ceiling": (lift, lambda: lift(catch=9.0), 0.4),
}


def advice(work: WorkPrecision, *tolerances: float) -> str:
    return work.advice(tolerances or (1e-2, 1e-3))


def refuses(work: WorkPrecision, output: str | None = None) -> str:
    """What is said instead of advice for 1 % and less."""
    said = work.advice((1e-2, 1e-3), output)
    assert "cheapest" not in said, said
    assert work.cheapest(1e-2, output) is None
    return said


@pytest.mark.parametrize("missed", ["a graze", *(pytest.param(m, marks=pytest.mark.slow) for m in list(MISSED)[1:])])
def test_who_misses_something_at_nine_tolerances_does_not_become_the_reference(missed: str) -> None:
    build, seen, duration = MISSED[missed]
    methods = {"blind": blind(seen), "Moreau-Jean": moreau(duration), "generalised-alpha": alpha(duration),
               "event-driven": EVENTS}  # fmt: skip
    work = work_precision(build, methods, duration=duration, repeats=0, outputs=["motion"])
    reference = work.of().reference
    assert reference.label != "blind"
    assert any(note.startswith("blind converges elsewhere: motion") for note in reference.notes)
    said = refuses(work)
    assert "is confirmed only within" in said
    assert "blind converges elsewhere" in said
    least = min(p.errors["motion"] for p in work.points if p.method == "blind")
    assert all(work.cheapest(tolerance) is None for tolerance in (0.5 * least, 0.99 * least))
    without = {label: series for label, series in methods.items() if label != "blind"}
    sound = work_precision(build, without, duration=duration, repeats=0, outputs=["motion"])
    assert advice(sound, 1e-2).startswith("cheapest method for 1 % in motion: ")
    assert not sound.of().reference.notes


def test_one_that_alone_sees_is_not_outvoted() -> None:
    build, seen, duration = MISSED["a graze"]
    methods = {"blind": blind(seen)[::3], "blind, too": blind(seen, MissesToo)[::3], "event-driven": EVENTS}
    work = work_precision(build, methods, duration=duration, repeats=0, outputs=["motion"])
    assert "event-driven converges elsewhere" in refuses(work)


@pytest.mark.parametrize("series", [EVENTS, moreau(1.0), blind(lambda: graze(aside=1.0))[3:6]])
def test_a_family_that_agrees_with_itself_alone_promises_nothing(series: list[Any]) -> None:
    methods = {"coarse": series[:-1], "fine": series[1:]}  # two labels are not two methods
    work = work_precision(graze, methods, duration=1.0, repeats=0, outputs=["motion"])
    said = refuses(work)
    assert "no independent method confirms the reference" in said
    assert f"no family but {type(series[0]).__name__}" in said
    assert "no family but" in work.table()


def test_a_stepper_that_is_given_as_reference_needs_a_witness_too() -> None:
    build, seen, duration = MISSED["a graze"]
    work = work_precision(build, {"event-driven": EVENTS, "Moreau-Jean": moreau(duration)}, Misses(1e-9, seen),
                          duration=duration, repeats=0, outputs=["motion"])  # fmt: skip
    assert work.of().reference.error["motion"] < 1e-6
    assert "converges elsewhere" in refuses(work)
    alone = work_precision(build, {"event-driven": EVENTS}, lf.EventDriven(rtol=1e-9), duration=duration, repeats=0,
                           outputs=["motion"])  # fmt: skip
    assert "no independent method" in refuses(alone)


def oscillator() -> lf.Scene:
    """A disc turns on a torsion spring, once a second, without friction."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.1, mass=1.0), name="disc", angle=0.1)
    centre = scene.ground.at(0.0, 0.0)
    scene.join(lf.Revolute(disc.point("center"), centre))
    scene.load(lf.TorsionSpring(disc.point("center"), centre, stiffness=0.005 * (2.0 * math.pi) ** 2, angle=0.0))
    return scene


TIP = {"tip": lambda result: result.q[:, 2]}


def true_tip(t: np.ndarray) -> np.ndarray:
    return np.asarray(0.1 * np.cos(2.0 * np.pi * t))


LONG = 200.0  # periods of it
FEW = 8_000  # steps: half a period late at the end


def test_the_shape_of_a_curve_is_no_promise_on_its_phase() -> None:
    methods = {"generalised-alpha": alpha(LONG, FEW)}
    work = full_study(oscillator, methods, {"tip": true_tip}, outputs=TIP, duration=LONG, repeats=0)
    drifting = work.cheapest(1e-2)
    assert drifting is not None
    assert drifting.errors["tip"] < 4e-3
    assert drifting.at_equal_times["tip"].largest > 0.9
    first, second = advice(work, 1e-2).splitlines()
    assert first.endswith("no promise on phase)")
    assert f"{100.0 * drifting.at_equal_times['tip'].largest:.2g} % where they differ most" in first
    assert second == "no method reached 1 % in tip at equal times"
    assert work.cheapest(1e-2, at_equal_times=True) is None
    assert f"({drifting.at_equal_times['tip'].largest:.1e})" in work.table()
    shown = [line for line in work.plot().axes[1].lines if line.get_linestyle() == "None" and len(line.get_xdata())]
    assert shown[0].get_ydata()[0] == drifting.at_equal_times["tip"].mean


def test_a_method_that_keeps_time_is_named_beside_the_one_that_does_not() -> None:
    methods = {"generalised-alpha": alpha(LONG, FEW), "event-driven": [lf.EventDriven(rtol=1e-10, atol=1e-11)]}
    work = full_study(oscillator, methods, {"tip": true_tip}, outputs=TIP, duration=LONG, repeats=0)
    timely = work.cheapest(1e-2, at_equal_times=True)
    assert timely is not None
    assert timely.method == "event-driven"
    assert timely.at_equal_times["tip"].mean < 1e-2
    first, *others = advice(work, 1e-2).splitlines()
    if "generalised-alpha" in first:  # the cheaper one
        assert first.endswith("no promise on phase)")
        assert others[0].startswith("cheapest method for 1 % in tip at equal times: event-driven")
    else:
        assert "at equal times within" in first


def test_at_equal_times_nothing_is_promised_where_the_reference_itself_drifts() -> None:
    methods = {"generalised-alpha": alpha(LONG, FEW), "event-driven": [lf.EventDriven(rtol=1e-9, atol=1e-10)]}
    reference = lf.GeneralizedAlpha(step=LONG / FEW / 1.1)
    work = full_study(oscillator, methods, reference, outputs=TIP, duration=LONG, repeats=0)
    assert work.of().reference.at_equal_times["tip"].mean > 0.05
    assert work.cheapest(2e-2, at_equal_times=True) is None
    said = advice(work, 2e-2).splitlines()
    assert all("no promise on phase" in line for line in said if "cheapest" in line)


@pytest.mark.slow
def test_chaos_is_no_accuracy() -> None:
    def pendulum() -> lf.Scene:
        scene = lf.Scene(gravity=(0.0, -9.81))
        upper = scene.add(lf.Box(1.0, 0.02, mass=1.0), name="upper", position=(0.5, 0.0))
        lower = scene.add(lf.Box(1.0, 0.02, mass=1.0), name="lower", position=(1.5, 0.0))
        scene.join(lf.Revolute(upper.at(-0.5, 0.0), scene.ground.at(0.0, 0.0)))
        scene.join(lf.Revolute(lower.at(-0.5, 0.0), upper.at(0.5, 0.0)))
        return scene

    duration = 25.0
    methods = {"event-driven": [lf.EventDriven(rtol=r, atol=0.1 * r) for r in (1e-7, 1e-8, 1e-9)],
               "Moreau-Jean": moreau(duration, 20_000, 40_000)}  # fmt: skip
    work = work_precision(pendulum, methods, duration=duration, repeats=0, outputs=["motion"], instants=2000)
    assert "no method can be said to have reached 1 % in motion" in refuses(work)


def sideways(result: lf.Result) -> np.ndarray:
    """The position across a straight path: 0."""
    return np.zeros(len(result.times))


@pytest.mark.parametrize("nothing", [sideways, lambda result: 0.0])
def test_an_output_that_is_zero_is_neither_exact_nor_wrong(nothing: Callable[[lf.Result], Any]) -> None:
    methods = {"Moreau-Jean": moreau(0.5), "event-driven": EVENTS}
    both = {"aside": nothing, "ahead": lambda result: result.q[:, 0]}
    work = work_precision(gallery.block_on_incline, methods, outputs=both, duration=0.5, repeats=0)
    assert [output.name for output in work.of().outputs] == ["ahead"]
    assert any("aside: 0 throughout" in note and "scale" in note for note in work.of().notes)
    with pytest.raises(ModelError, match="aside: 0 throughout, no error is relative to that"):
        work_precision(gallery.block_on_incline, methods, outputs={"aside": nothing}, duration=0.5, repeats=0)
    scaled = {"aside": Output("aside", nothing, scale=1.0)}
    known = work_precision(gallery.block_on_incline, methods, outputs=scaled, duration=0.5, repeats=0)
    assert all(point.errors["aside"] < 1e-12 for point in known.points)


def test_a_peak_force_of_impacts_is_not_compared() -> None:
    methods = {"Moreau-Jean": moreau(1.0), "generalised-alpha": alpha(1.0), "event-driven": EVENTS}
    work = work_precision(gallery.bouncing_ball, methods, duration=1.0, repeats=0,
                          outputs=["peak force", "peak impulse"])  # fmt: skip
    assert [output.name for output in work.of().outputs] == ["peak impulse"]
    assert any("'peak force']: not defined for a run with impacts" in note for note in work.of().notes)
    assert work.cheapest(1e-2, "peak impulse") is not None
    with pytest.raises(ModelError, match=r"not defined for a run with impacts.*expected 'peak impulse'"):
        work_precision(gallery.bouncing_ball, methods, duration=1.0, repeats=0, outputs=["peak force"])


def test_a_peak_force_without_impacts_is() -> None:
    methods = {"Moreau-Jean": moreau(0.5), "event-driven": EVENTS}
    work = work_precision(gallery.block_on_incline, methods, duration=0.5, repeats=0, outputs=["peak force"])
    assert work.cheapest(1e-2) is not None


@pytest.mark.parametrize("instants", [20, 60])
def test_a_coarse_record_is_told_from_a_method(instants: int) -> None:
    speed = {"speed": lambda result: result.u[:, 1]}
    methods = {"Moreau-Jean": moreau(1.0, 1000, 3000), "event-driven": EVENTS}
    work = work_precision(gallery.bouncing_ball, methods, outputs=speed, duration=1.0, repeats=0, instants=instants)
    study = work.of()
    finest = [point for point in study.points if point.steps == 3000]
    assert all(study.recorded(point, "speed") for point in finest)
    assert study.cheapest(1e-3) is None
    assert "| <* " in work.table()
    words = [text.get_text() for text in work.plot().axes[3].get_legend().get_texts()]
    assert "half full: below the error of the record" in words
    finely = work_precision(gallery.bouncing_ball, methods, outputs=speed, duration=1.0, repeats=0)
    assert not any(finely.of().recorded(p, "speed") for p in finely.points if p.steps == 3000)


def test_a_force_law_that_creeps_is_no_reference_for_a_block_that_sticks() -> None:
    def held() -> lf.Scene:
        return gallery.block_on_incline(friction=0.8)

    law = lf.Penalty(1e5, damping=300.0, slip_speed=1e-2)
    creeping = [lf.Smooth(law, integrator=lf.ExplicitRungeKutta(rtol=r, atol=0.1 * r)) for r in (1e-4, 1e-6)]
    alone = work_precision(held, {"penalty": creeping}, duration=0.3, repeats=0, outputs=["motion"])
    refuses(alone)
    methods = {"penalty": creeping, "Moreau-Jean": moreau(0.3), "event-driven": EVENTS}
    work = work_precision(held, methods, duration=0.3, repeats=0, outputs=["motion"])
    assert work.of().reference.label != "penalty"
    best = work.cheapest(1e-2)
    assert best is None or best.method != "penalty"


def test_single_runs_of_two_methods_that_disagree_are_no_accuracy() -> None:
    """Neither has a second run, so that neither is known to have converged."""
    coarse = {"Moreau-Jean": moreau(0.5, 50, 55), "generalised-alpha": alpha(0.5, 30)}
    work = work_precision(gallery.block_on_incline, coarse, duration=0.5, repeats=0, outputs=["motion"])
    other = work.points[-1].errors["motion"]
    assert other > work.of().reference.error["motion"]
    assert work.of().reference.reach("motion") == other
    assert work.cheapest(other) is None


SOUND = {
    "incline": (gallery.block_on_incline, 0.5),
    "ball": (gallery.bouncing_ball, 1.0),
    "oblique": (gallery.scenes()["oblique_bounce"], 1.0),
    "stick and slip": (gallery.scenes()["stick_slip"], 1.9),
}


@pytest.mark.parametrize("name", ["incline", *(pytest.param(m, marks=pytest.mark.slow) for m in list(SOUND)[1:])])
def test_sound_scenes_get_advice_and_its_stepper_can_be_run(name: str) -> None:
    scene, duration = SOUND[name]
    methods = {"Moreau-Jean": moreau(duration), "generalised-alpha": alpha(duration), "event-driven": EVENTS}
    work = work_precision(scene, methods, duration=duration, repeats=0)
    assert not work.of().reference.notes
    best = work.cheapest(1e-2, at_equal_times=True)
    assert best is not None
    assert "cheapest method for 1 % in trajectory" in advice(work)
    assert "agrees to" in advice(work)
    build = getattr(scene, "build", scene)
    result = lf.simulate(build(), duration, best.stepper, progress=False)
    assert result.complete


@pytest.mark.slow
@pytest.mark.parametrize("name", ["pendulum", "three_balls", "elastic_stop", "rocking_block"])
def test_flexible_and_multiple_contacts_are_advised_on_or_told_apart(name: str) -> None:
    """Whatever is advised holds against a run that is finer than all of the study."""
    case = gallery.scenes()[name]
    try:
        work = work_precision(case, limit=1.0, repeats=0, outputs=["motion"])
    except ModelError as refusal:  # on a slow machine, of steps as long as the limit asks for
        if "no method has two sound runs" not in str(refusal):
            raise
        return
    best = work.cheapest(1e-2)
    if best is None:
        assert "no method" in advice(work, 1e-2)
        return
    truth = work_precision(case, {"best": [best.stepper]}, lf.EventDriven(rtol=1e-11, atol=1e-12),
                           outputs=["motion"], repeats=0)  # fmt: skip
    assert truth.points[0].errors["motion"] <= 1e-2 + truth.of().reference.error["motion"]
