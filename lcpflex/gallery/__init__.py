"""Reference scenes, each with what must come out where that is known exactly.

    from lcpflex import gallery, simulate

    case = gallery.scenes()["bouncing_ball"]
    result = simulate(case.build(), case.duration, case.stepper)

Tests, examples, charts and the command line take their scenes from here. The functions have parameters:
``gallery.elastic_bar(elements=100)``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from lcpflex.basics.lazy import attach

if TYPE_CHECKING:
    from lcpflex.gallery.collection import scenes as scenes
    from lcpflex.gallery.mechanisms.bars import (
        bar_with_foot as bar_with_foot,
        elastic_bar as elastic_bar,
        prestressed_bar as prestressed_bar,
        two_bars as two_bars,
    )
    from lcpflex.gallery.mechanisms.claws import claw as claw, claw_in_step as claw_in_step
    from lcpflex.gallery.mechanisms.coaxial import (
        meshed_ball as meshed_ball,
        meshed_rod as meshed_rod,
        meshed_sphere_on_rod as meshed_sphere_on_rod,
    )
    from lcpflex.gallery.mechanisms.flexible import (
        hemisphere_pendulum as hemisphere_pendulum,
        pendulum as pendulum,
        sliding_beam as sliding_beam,
    )
    from lcpflex.gallery.mechanisms.piles import (
        brick_wall as brick_wall,
        heap as heap,
        hopper as hopper,
        link_chain as link_chain,
        silo as silo,
        strip_pile as strip_pile,
    )
    from lcpflex.gallery.mechanisms.plates import sphere_on_plate as sphere_on_plate
    from lcpflex.gallery.mechanisms.rigid import (
        block_on_incline as block_on_incline,
        bouncing_ball as bouncing_ball,
        double_pendulum as double_pendulum,
        oblique_bounce as oblique_bounce,
        painleve_friction as painleve_friction,
        painleve_rod as painleve_rod,
        rocking_block as rocking_block,
        spring_block as spring_block,
        stack as stack,
        stick_slip_block as stick_slip_block,
        three_balls as three_balls,
    )
    from lcpflex.gallery.mechanisms.space import (
        dzhanibekov as dzhanibekov,
        heavy_top as heavy_top,
        spatial_slider_crank as spatial_slider_crank,
        spherical_pendulum as spherical_pendulum,
    )
    from lcpflex.gallery.mechanisms.space_contact import (
        billiard_ball as billiard_ball,
        euler_disc as euler_disc,
        puck as puck,
        rolling_disc as rolling_disc,
        sliding_puck as sliding_puck,
        tippe_top as tippe_top,
    )
    from lcpflex.gallery.mechanisms.stops import (
        elastic_stop as elastic_stop,
        hinged_beam as hinged_beam,
        sphere_on_beam as sphere_on_beam,
        sphere_on_rod as sphere_on_rod,
    )
    from lcpflex.gallery.mechanisms.user_systems import (
        impacting_bar as impacting_bar,
        slider_crank as slider_crank,
        woodpecker as woodpecker,
    )
    from lcpflex.gallery.warmup import warmup_cases as warmup_cases
    from lcpflex.runs.case import Case as Case

__getattr__, __dir__ = attach(__name__)
