"""Some instants of a run as a result of their own, for what is measured of them."""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.force_laws.friction.creep import creeping
from lcpflex.results.contact_history import ContactPoints
from lcpflex.results.energy_balance import Energies
from lcpflex.results.result import Result
from lcpflex.results.stored_instants import stored_as
from lcpflex.runs.touched import told
from lcpflex.steppers.recorder import IN_SPACE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lcpflex.runs.setup import Setup
    from lcpflex.runs.touched import Told
    from lcpflex.steppers.records import Page, Records

__all__ = ["page_result", "touching_points", "with_creep"]


def page_result(setup: Setup, records: Records, page: Page) -> Result:
    """The instants of a page; its contacts are those declared and all pairs of a rule that have come near so far."""
    found = told(setup.system, setup.compiled, setup.names, records, [], page)
    data = found.data
    stored: dict[str, Any] = {field.name: data[field.name] for field in fields(Result) if field.name in data}
    return Result(
        **stored
        | {
            "state": with_creep(found.laws, data["state"]),
            "energies": Energies.audit(*(data["energies"][:, i] for i in range(7))),
        },
        contact_points=touching_points(found),
        events=(),
        warnings=(),
        complete=False,
        message="",
        steps=max(1, len(data["times"])),
        wall_time=0.0,
        compile_time=0.0,
        stepper=repr(setup.stepper),
        duration=setup.options.duration,
        stored=stored_as(setup.options.interval),
        compiled=found.compiled,
        contact_names=found.names,
        compliant=records.compliant,
    )


def touching_points(found: Told) -> ContactPoints:
    """The touching points of what a run has stored."""
    touching = found.data["points"]
    contact = touching[:, 1].astype(np.int64)
    d = 3 if touching.shape[1] == IN_SPACE else 2
    forces = 2 + 2 * d
    return ContactPoints(
        record=touching[:, 0].astype(np.int64),
        contact=contact,
        place=touching[:, 2 : 2 + d],
        normal=touching[:, 2 + d : 2 + 2 * d],
        force=touching[:, forces : forces + (4 if d == 3 else 2)],
        state=creeping(found.laws, contact, touching[:, -1]).astype(np.int8),
        area=touching[:, -2] if d == 3 else np.zeros(len(touching)),
    )


def with_creep(laws: Sequence[Any], state: NDArray[Any]) -> NDArray[np.int8]:
    """States (m, nc) as a result tells them."""
    everywhere = np.broadcast_to(np.arange(state.shape[1]), state.shape)
    return creeping(laws, everywhere, state).astype(np.int8)
