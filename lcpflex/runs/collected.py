"""What a run has come to, as a result: all that it has stored, and what looking at the whole has to say of it."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.checks.axial_loads import with_axial_loads
from lcpflex.checks.damping_in_time import ringing_dampers
from lcpflex.checks.grown import gone_too_far
from lcpflex.checks.kept_depth import kept_depths
from lcpflex.checks.loads_in_time import with_unseen_loads
from lcpflex.checks.rebound import rebounds
from lcpflex.checks.resolution import unresolved
from lcpflex.dynamics.impact_laws import Newton
from lcpflex.force_laws.friction.creep import crept
from lcpflex.results.energy_balance import (
    Energies,
    energy_doubts,
    energy_warnings,
    held_energy,
    load_energy,
)
from lcpflex.results.motion_units import has_moved
from lcpflex.results.result import Event, Result
from lcpflex.results.stored_instants import stored_as
from lcpflex.runs.page_result import touching_points, with_creep
from lcpflex.runs.setup import Options, Run, Setup, Stepper
from lcpflex.runs.touched import told
from lcpflex.steppers.law_run import friction_warnings

if TYPE_CHECKING:
    from lcpflex.steppers.system import System

__all__ = ["check_result", "collect", "growth_cause"]


def collect(setup: Setup, run: Run, timing: tuple[float, float], message: str, complete: bool) -> Result:
    """Everything that the run has stored, as a result."""
    stepper, system, options = setup.stepper, setup.system, setup.options
    found = told(system, setup.compiled, setup.names, run.records, run.events)
    compiled, names, data, laws = found.compiled, found.names, found.data, found.laws
    growth, loads = growth_cause(stepper, system), load_energy(compiled)
    held = held_energy(compiled, data["times"], data["impulse"])
    energies = Energies.audit(*(data["energies"][:, i] for i in range(7)))
    coarse = tuple(system.names[law] for law in run.records.touches.enough())
    grown = None
    if coarse and len(data["times"]):
        from lcpflex.results.unexplained import certain_growth  # which other runs do without

        grown = certain_growth(energies, data["times"], data["force"], np.isin(names, coarse), run.steps)
    moved = compiled is not None and has_moved(found.model, data["q"], data["u"], compiled.size)
    pressed = np.count_nonzero(data["force"][:, :, 0] > 0.0, axis=0) / max(len(data["times"]), 1)
    state = with_creep(laws, data["state"])
    events = tuple(
        Event(time=at, kind=kind, contact=setup.contact_name(law) if law >= 0 else "", energy_change=change)
        for at, kind, law, change in run.events
    )
    stored: dict[str, Any] = {field.name: data[field.name] for field in fields(Result) if field.name in data}
    return Result(
        **stored | {"state": state, "energies": energies},
        contact_points=touching_points(found),
        sensors=setup.sensing.histories(run.records),
        events=events,
        warnings=(
            *(compiled.warnings if compiled is not None else ()),
            *run.records.warnings,
            *friction_warnings(names, run.records.missed_friction, pressed),
            *energy_warnings(
                energies,
                run.records.gain,
                complete,
                options.energy_growth,
                run.steps,
                growth,
                _tolerance(stepper),
                held,
            ),
        ),
        complete=complete,
        message=message,
        steps=run.steps,
        wall_time=timing[0],
        compile_time=timing[1],
        stepper=repr(stepper),
        duration=options.duration,
        stored=stored_as(options.interval),
        compiled=compiled,
        contact_names=names,
        compliant=run.records.compliant,
        coarse=coarse,
        crept=crept(laws, found.model.contacts.friction[: len(laws)], data["times"], state, data["force"]),
        found_wrong=(
            *options.began_wrong,
            *run.records.wrong(),
            *energy_doubts(
                energies,
                run.records.gain,
                options.energy_growth,
                run.steps,
                loads,
                held,
                compiled is not None,
                moved,
                grown,
                data["times"],
            ),
        ),
        notes=(
            *(compiled.notes if compiled is not None else ()),
            *_choice(options),
            *options.notes,
            *run.records.notes,
        ),
        impact_step=run.records.impact_step,
        step_tolerance=run.records.step_tolerance(data["q"]),
    )


def _choice(options: Options) -> tuple[str, ...]:
    """How the stepper was chosen, where the library did."""
    return (options.choice.note,) if options.choice is not None and options.choice.why else ()


def check_result(result: Result, setup: Setup, run: Run) -> Result:
    """With what looking at the whole run has to say of it."""
    result = replace(result, warnings=(*result.warnings, *unresolved(result), *rebounds(result), *kept_depths(result)))
    if result.compiled is not None and len(result.compiled.model.bodies.stiffness):
        from lcpflex.checks.flat_contacts import with_flat_contacts  # which rigid bodies do without

        result = with_flat_contacts(result)
    if result.compiled is not None and len(getattr(result.compiled.model.contacts, "cell_point", ())):
        from lcpflex.checks.below_faces import sunk_below_faces  # of solids alone
        from lcpflex.checks.face_rims import reached_rims
        from lcpflex.checks.shared_areas import wrong_areas

        told = (*sunk_below_faces(result), *reached_rims(result), *wrong_areas(result))
        result = replace(result, warnings=(*result.warnings, *told))
    step = getattr(run, "fixed_step", 0.0)
    result = with_axial_loads(_with_shared_bodies(result, step))
    if (calls := setup.system.calls) is not None:
        result = replace(result, python_calls=calls.number, python_time=calls.time)
    if rows := gone_too_far(result, setup.system.model):
        from lcpflex.checks.jumped_gaps import sunk_by_jumps  # which other runs do without

        sunk = sunk_by_jumps(result, rows, setup.system, setup.source)
        result = replace(result, found_wrong=(*result.found_wrong, *sunk))
    if step:
        result = with_unseen_loads(result, step, setup.source)
        result = replace(result, warnings=(*result.warnings, *ringing_dampers(result, step, setup.stepper)))
    return result


def _with_shared_bodies(result: Result, step: float) -> Result:
    """With what is to be said of contacts that share bodies, where there may be such."""
    if len(result.contact_names) < 2 and np.bincount(result.contact_points.record, minlength=1).max() < 2:
        return result
    from lcpflex.checks.shared_loads import shared_loads
    from lcpflex.checks.strikes_in_turn import strikes_in_turn
    from lcpflex.checks.struck_together import struck_together

    notes = (*result.notes, *struck_together(result), *shared_loads(result))
    turns = strikes_in_turn(result, step) if step else ()
    return replace(result, notes=notes, warnings=(*result.warnings, *turns))


def _tolerance(stepper: Stepper) -> float:
    """Relative error of a step that error control was asked for; 0 without."""
    owners = (getattr(stepper, "adaptive", None), stepper, getattr(stepper, "integrator", None))
    return max((float(getattr(owner, "rtol", 0.0)) for owner in owners), default=0.0)


def growth_cause(stepper: Stepper, system: System) -> str:
    """What lets contact impulses create energy in a run of ``stepper``: only a law that is in it is blamed."""
    contacts = system.model.contacts
    bounces = bool(contacts.restitution.any() or contacts.tangential_restitution.any())
    fixed = hasattr(stepper, "step") and getattr(stepper, "adaptive", None) is None
    shorter = "a shorter step" if fixed else "tighter tolerances"
    if bounces and contacts.friction.any() and isinstance(getattr(stepper, "impact", Newton()), Newton):
        return f"Newton's restitution with friction does so; if not, {shorter} will help"
    return f"no contact law of this run does so: take {shorter}"
