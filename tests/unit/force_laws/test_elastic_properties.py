"""Elastic laws of bodies of any size and material: zero at the touch, continuous, monotone and convex."""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
from lcpflex.force_laws.elastic.explicit_line_laws import LankaraniNikraveshCylinder, Liu, Pereira, Persson
from lcpflex.force_laws.elastic.hertz import Hertz
from lcpflex.force_laws.elastic.line_contact import DubowskyFreudenstein, Esdu78035, Goldsmith, Johnson, Radzimovsky
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.force_laws.elastic.power_law import PowerLaw
from tests.chance import assume, given, settings, st

RADII = st.floats(1e-4, 0.9)
MODULI = st.floats(1e6, 1e12)
RATIOS = st.floats(-0.9, 0.49)
MATERIALS = st.builds(Material, MODULI, RATIOS)


@st.composite
def any_law(draw):
    """A law of any kind, of two bodies of any size and material."""
    small, share, length = draw(RADII), draw(st.floats(1e-3, 20.0)), draw(st.floats(1e-4, 0.99))
    material, other = draw(MATERIALS), draw(MATERIALS)
    large = small * (1.0 + share)
    hole = CylinderPair.internal(large, small, length, material, other)
    side = CylinderPair.external(large, small, length, material, other)
    pair = draw(st.sampled_from([hole, side]))
    kind = draw(
        st.sampled_from([PowerLaw, Hertz, Johnson, Radzimovsky, Goldsmith, DubowskyFreudenstein, Esdu78035, Liu])
        | st.sampled_from([LankaraniNikraveshCylinder, Pereira, Persson])
    )
    if kind is PowerLaw:
        return PowerLaw(draw(st.floats(1.0, 1e12)), draw(st.floats(1.0, 3.0)))
    if kind is Hertz:
        make = draw(st.sampled_from([Hertz.spheres, Hertz.sphere_in_cup]))
        return make(small, large, material, other)
    if kind is Goldsmith:
        return Goldsmith(pair, m=draw(st.floats(1.0, 4.0)))
    if kind is Radzimovsky:
        return Radzimovsky(pair, handbook=draw(st.booleans()))
    if kind is Esdu78035:
        return Esdu78035(hole, draw(st.sampled_from(["pi", "review"])))
    if kind is Persson:
        return Persson(CylinderPair.internal(large, small, length, material))
    if kind is Liu:
        return Liu(hole)
    if kind is Pereira:
        assume(not pair.is_internal or 0.005 <= 1e3 * pair.clearance <= 10.0)
    return kind(pair)


@settings(max_examples=150)
@given(law=any_law())
def test_every_law_begins_at_zero_and_is_continuous_monotone_and_convex(law):
    delta = np.concatenate([[0.0], min(law.limit, 1e-3) * np.geomspace(1e-9, 1.0, 80)])
    force, stiffness, energy = law.force(delta), law.stiffness(delta), law.energy(delta)
    assert force[0] == energy[0] == 0.0
    assert (force[1:] > 0.0).all()
    assert (np.diff(force) > 0.0).all()
    assert (np.diff(stiffness) >= -1e-12 * stiffness[1:]).all()
    # A convex function lies between its tangents: no jump, however small the interval.
    for width in (1e-2, 1e-5):
        ahead = delta * (1.0 - width)
        rise, slack = force - law.force(ahead), 1e-12 * force
        assert (rise <= stiffness * delta * width + slack).all()
        assert (rise >= law.stiffness(ahead) * delta * width - slack).all()
    # between the triangle and the tangent
    assert (energy <= 0.5 * force * delta * (1.0 + 1e-12)).all()
    assert (np.diff(energy) <= force[1:] * np.diff(delta) * (1.0 + 1e-9)).all()
    assert (np.diff(energy) >= force[:-1] * np.diff(delta) * (1.0 - 1e-9)).all()
    back = law.indentation(force * (1.0 - 1e-12))
    assert back == pytest.approx(delta, rel=1e-10, abs=0.0)
