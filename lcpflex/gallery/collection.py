"""All scenes of the gallery by name; the module of one is loaded when it is asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lcpflex.runs.case import Case

__all__ = ["scenes"]

# Modules of lcpflex.gallery.mechanisms, and the names of their cases.
HOMES = {
    "flexible": ("pendulum", "smooth_pendulum", "hemisphere", "sliding_beam"),
    "rigid": (
        "incline",
        "incline_sticks",
        "stick_slip",
        "spring_block",
        "bouncing_ball",
        "oblique_bounce",
        "three_balls",
        "rocking_block",
        "double_pendulum",
        "painleve_rod",
        "stack",
        "heavy_stack",
    ),
    "bars": (
        "elastic_bar",
        "modal_bar_1",
        "modal_bar_2",
        "modal_bar_3",
        "two_bars",
        "prestressed_bar",
        "bar_with_foot",
    ),
    "user_systems": ("woodpecker", "slider_crank", "impacting_bar"),
    "stops": ("elastic_stop", "hinged_beam", "sphere_on_beam", "sphere_on_rod"),
    "coaxial": ("meshed_sphere_on_rod",),
    "piles": ("heap", "brick_wall", "struck_wall", "strip_pile", "link_chain", "hopper", "smooth_hopper", "silo"),
    "space": (
        "dzhanibekov",
        "heavy_top",
        "released_top",
        "driven_slider_crank",
        "free_slider_crank",
        "spherical_pendulum",
    ),
    "space_contact": ("billiard_ball", "sliding_puck", "puck", "euler_disc", "rolling_disc", "tippe_top"),
    "plates": ("sphere_on_plate",),
}


def scenes() -> Mapping[str, Case]:
    """All cases by name."""
    return _Scenes()


class _Scenes(Mapping[str, "Case"]):
    """Names are known, and a case is made with those beside it when it is asked for."""

    def __init__(self) -> None:
        self._home = {name: home for home, names in HOMES.items() for name in names}
        self._made: dict[str, Case] = {}

    def __getitem__(self, name: str) -> Case:
        if name not in self._made:
            home = import_module(f"lcpflex.gallery.mechanisms.{self._home[name]}")
            self._made |= {case.name: case for case in home.cases()}
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self._home

    def __iter__(self) -> Iterator[str]:
        return iter(self._home)

    def __len__(self) -> int:
        return len(self._home)

    def __repr__(self) -> str:
        return f"<scenes of the gallery: {', '.join(self)}>"
