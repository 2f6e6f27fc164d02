"""How much of its duration a scene is run, where all of it costs much: a share for a stepper, or for a kind of them.

"events" are all event-driven steppers, "controlled" those with adaptive steps. What is not listed runs to its end.
Each share was measured once, for about 0.4 s of computing a run, and is at least so long that the first bodies touch,
and a tenth longer. It is a number and no clock: every checkout makes the same steps. A scene that is new, or has become
dear, gets a line here.
"""

from __future__ import annotations

__all__ = ["SHARES", "TOO_STIFF"]

SHARES: dict[str, dict[str, float]] = {
    "pendulum": {"controlled": 0.73, "events": 0.73, "smooth-stiff": 0.73},
    "smooth_pendulum": {"smooth-stiff": 0.87},
    "sliding_beam": {
        "own": 0.39,
        "controlled": 0.19,
        "events": 0.19,
        "massless-boundary": 0.19,
        "smooth": 0.19,
        "smooth-stiff": 0.19,
        "smooth-verlet": 0.24,
    },
    "incline_sticks": {"smooth-stiff": 0.055},
    "stick_slip": {"smooth-stiff": 0.36},
    "rocking_block": {"smooth-stiff": 0.11},
    "stack": {"smooth": 0.31, "smooth-stiff": 0.037},
    "heavy_stack": {"smooth": 0.51, "smooth-stiff": 0.14},
    "elastic_bar": {"controlled": 0.36, "events": 0.36, "smooth": 0.36},
    "two_bars": {"controlled": 0.33, "events": 0.28, "smooth": 0.21},
    "prestressed_bar": {"controlled": 0.53, "events": 0.24, "smooth": 0.14, "smooth-stiff": 0.092},
    "bar_with_foot": {"controlled": 0.082, "events": 0.019, "smooth": 0.0011},
    "woodpecker": {
        "own": 0.034,
        "controlled": 0.18,
        "generalized-alpha": 0.41,
        "events": 0.035,
        "smooth": 0.014,
        "smooth-stiff": 0.018,
        "smooth-verlet": 0.044,
    },
    "slider_crank": {
        "controlled": 0.55,
        "generalized-alpha": 0.37,
        "smooth": 0.32,
        "smooth-stiff": 0.36,
        "smooth-verlet": 0.25,
    },
    "impacting_bar": {
        "own": 0.46,
        "moreau-jean": 0.57,
        "controlled": 0.36,
        "generalized-alpha": 0.36,
        "events": 0.36,
        "smooth": 0.36,
        "smooth-verlet": 0.36,
    },
    "hinged_beam": {"own": 0.57},
    "meshed_sphere_on_rod": {
        "own": 0.51,
        "moreau-jean": 0.11,
        "controlled": 0.051,
        "events": 0.01,
        "smooth": 0.0064,
        "smooth-stiff": 0.45,
        "smooth-verlet": 0.0015,
    },
    "heap": {"controlled": 0.11, "generalized-alpha": 0.28, "events": 0.059, "smooth": 0.034},
    "brick_wall": {"smooth": 0.23},
    "struck_wall": {"controlled": 0.001, "generalized-alpha": 0.092, "events": 0.041, "smooth": 0.0059},
    "strip_pile": {
        "own": 0.36,
        "moreau-jean": 0.55,
        "controlled": 0.022,
        "generalized-alpha": 0.08,
        "events": 0.022,
        "smooth": 0.022,
        "smooth-stiff": 0.022,
        "smooth-verlet": 0.19,
    },
    "link_chain": {"controlled": 0.37, "events": 0.56},
    "hopper": {"controlled": 0.066, "generalized-alpha": 0.2, "events": 0.06, "smooth": 0.059},
    "smooth_hopper": {"controlled": 0.096, "generalized-alpha": 0.52, "events": 0.084, "smooth": 0.4},
    "silo": {
        "own": 0.17,
        "moreau-jean": 0.26,
        "controlled": 0.061,
        "generalized-alpha": 0.12,
        "events": 0.059,
        "smooth": 0.027,
    },
    "billiard_ball": {"smooth-stiff": 0.46},
    "euler_disc": {"smooth-stiff": 0.26},
    "rolling_disc": {"smooth-stiff": 0.11},
    "tippe_top": {"smooth-stiff": 0.021},
    "sphere_on_plate": {"smooth-verlet": 0.44},
}

# Their first touch takes seconds of an implicit method with a Jacobian by differences, which is for few coordinates.
TOO_STIFF = (
    "bar_with_foot", "brick_wall", "elastic_bar", "heap", "hopper", "link_chain", "silo", "smooth_hopper",
    "sphere_on_plate", "struck_wall", "two_bars",
)  # fmt: skip
