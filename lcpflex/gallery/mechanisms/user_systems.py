"""Scenes given by their own equations M, h, g, W: woodpecker toy, slider-crank with clearance, a bar."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.runs.case import Case
from lcpflex.scene.user_system import UserSystem
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.moreau_jean.stepper import MoreauJean

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray

__all__ = ["impacting_bar", "slider_crank", "woodpecker"]

GRAVITY = 9.81


@checked
def woodpecker(friction: float = 0.3) -> UserSystem:
    """Woodpecker toy: a sleeve with clearance on a pole, the bird on a torsion spring (Glocker & Studer 2005).

    q = (y, phi_M, phi_S): height of the sleeve, angles of sleeve and bird. Contacts: beak and two corners
    of the sleeve.
    """
    r_pole, r_sleeve, h_sleeve, l_sleeve = 0.0025, 0.0031, 0.0058, 0.010
    l_spring, h_bird, l_beak = 0.015, 0.02, 0.0201
    m_sleeve, m_bird, j_sleeve, j_bird = 0.0003, 0.0045, 5e-9, 7e-7
    c_spring = 0.0056
    mass = np.array([
        [m_bird + m_sleeve, m_bird * l_sleeve, m_bird * l_spring],
        [m_bird * l_sleeve, j_sleeve + m_bird * l_sleeve**2, m_bird * l_sleeve * l_spring],
        [m_bird * l_spring, m_bird * l_sleeve * l_spring, j_bird + m_bird * l_spring**2],
    ])  # fmt: skip
    weight = -GRAVITY * np.array([m_bird + m_sleeve, m_bird * l_sleeve, m_bird * l_spring])
    clearance = r_sleeve - r_pole
    normals = np.array([[0.0, 0.0, 0.0], [0.0, h_sleeve, -h_sleeve], [-h_bird, 0.0, 0.0]])
    tangents = np.array([[1.0, 1.0, 1.0], [l_sleeve, r_sleeve, r_sleeve], [l_spring - l_beak, 0.0, 0.0]])
    reach = np.array([l_sleeve + l_spring - l_beak - r_pole, clearance, clearance])
    return UserSystem(
        q=[0.0, -0.1036, -0.2788],
        u=[-0.3411, 0.0, -7.4583],
        mass=mass,
        force=lambda t, q, u: weight,
        gaps=lambda q: reach + normals.T @ q,
        normals=normals,
        tangents=tangents,
        normal_bias=lambda q, u: np.zeros(3),
        tangent_bias=lambda q, u: np.zeros(3),
        friction=friction,
        restitution=[0.5, 0.0, 0.0],
        names=("beak", "lower corner", "upper corner"),
        stiffness=c_spring * np.array([[0.0, 0.0, 0.0], [0.0, 1.0, -1.0], [0.0, -1.0, 1.0]]),
        potential=lambda q: -weight @ q,
    )


@checked
def slider_crank(restitution: float = 0.4, friction: float = 0.01, clearance: float = 0.001) -> UserSystem:
    """Slider-crank whose slider has play between its guides (Flores, Leine & Glocker 2010).

    q = angles of crank, rod and slider; the slider hangs on the rod by its centre. Contacts: its four corners (a to
    each side, b up and down) against guides b + c above and below the axis of the crank.
    """
    l1, l2, a, b = 0.153, 0.306, 0.05, 0.025
    m1, m2, m3, j1, j2, j3 = 0.038, 0.038, 0.076, 7.4e-5, 5.9e-4, 2.7e-6
    m11 = j1 + (m1 / 4.0 + m2 + m3) * l1**2
    m22 = j2 + (m2 / 4.0 + m3) * l2**2
    coupling = (m2 / 2.0 + m3) * l1 * l2
    weight = GRAVITY * np.array([(m1 / 2.0 + m2 + m3) * l1, (m2 / 2.0 + m3) * l2])
    along = np.array([-a, a, -a, a])  # corners in the frame of the slider
    across = np.array([b, b, -b, -b])
    side = np.sign(across)  # +1: upper guide

    def mass(q: FloatArray) -> FloatArray:
        m12 = coupling * math.cos(q[0] - q[1])
        return np.array([[m11, m12, 0.0], [m12, m22, 0.0], [0.0, 0.0, j3]])

    def force(t: float, q: FloatArray, u: FloatArray) -> FloatArray:
        whirl = coupling * math.sin(q[0] - q[1])
        gravity = weight * np.cos(q[:2])
        return np.array([-whirl * u[1] ** 2 - gravity[0], whirl * u[0] ** 2 - gravity[1], 0.0])

    def gaps(q: FloatArray) -> FloatArray:
        height = l1 * math.sin(q[0]) + l2 * math.sin(q[1]) + along * math.sin(q[2]) + across * math.cos(q[2])
        return np.asarray(b + clearance - side * height)

    def rise(q: FloatArray) -> FloatArray:
        """d(height of a corner)/dq, (3, 4)."""
        turn = along * math.cos(q[2]) - across * math.sin(q[2])
        return np.array([np.full(4, l1 * math.cos(q[0])), np.full(4, l2 * math.cos(q[1])), turn])

    def advance(q: FloatArray) -> FloatArray:
        """d(place of a corner along the guide)/dq, (3, 4)."""
        turn = -along * math.sin(q[2]) - across * math.cos(q[2])
        return np.array([np.full(4, -l1 * math.sin(q[0])), np.full(4, -l2 * math.sin(q[1])), turn])

    def normal_bias(q: FloatArray, u: FloatArray) -> FloatArray:
        swing = l1 * math.sin(q[0]) * u[0] ** 2 + l2 * math.sin(q[1]) * u[1] ** 2
        return np.asarray(side * (swing + (along * math.sin(q[2]) + across * math.cos(q[2])) * u[2] ** 2))

    def tangent_bias(q: FloatArray, u: FloatArray) -> FloatArray:
        swing = l1 * math.cos(q[0]) * u[0] ** 2 + l2 * math.cos(q[1]) * u[1] ** 2
        return np.asarray(side * (swing + (along * math.cos(q[2]) - across * math.sin(q[2])) * u[2] ** 2))

    return UserSystem(
        q=[0.0, 0.0, 0.0],
        u=[150.0, -75.0, 0.0],
        mass=mass,
        force=force,
        gaps=gaps,
        normals=lambda q: -side * rise(q),
        tangents=lambda q: -side * advance(q),
        normal_bias=normal_bias,
        tangent_bias=tangent_bias,
        friction=friction,
        restitution=restitution,
        names=("upper left", "upper right", "lower left", "lower right"),
        potential=lambda q: weight @ np.sin(q[:2]),
    )


@checked
def impacting_bar(nodes: int = 100) -> UserSystem:
    """The elastic bar of the Siconos examples, in its nodal coordinates: end node 0 against a wall, e_N = 0.

    Its matrices are those of that example: elements of length L/nodes, the end nodes with half an inner node's share.
    """
    youngs_modulus, density, section, length = 210e9, 7800.0, 3.14e-4, 1.0
    element = length / nodes
    side = np.eye(nodes, k=1) + np.eye(nodes, k=-1)
    ends = np.zeros(nodes)
    ends[[0, -1]] = 1.0
    mass = density * section * element * (np.diag(2.0 / 3.0 - ends / 3.0) + side / 6.0)
    stiffness = youngs_modulus * section / element * (np.diag(2.0 - ends) - side)
    normal = np.zeros((nodes, 1))
    normal[0] = 1.0
    at_rest = np.zeros(nodes)
    return UserSystem(
        q=np.full(nodes, 5e-5),
        u=np.full(nodes, -0.1),
        mass=mass,
        force=lambda t, q, u: at_rest,
        gaps=lambda q: q[:1],
        normals=normal,
        normal_bias=lambda q, u: np.zeros(1),
        names=("wall",),
        stiffness=stiffness,
        potential=lambda q: 0.0,
    )


def cases() -> tuple[Case, ...]:
    """The cases of this module."""
    return (
        Case(
            "woodpecker",
            "woodpecker toy: slides, jams and pecks down its pole (user-defined system)",
            woodpecker,
            0.5,
            MoreauJean(step=2e-5, gap_tolerance=0.0, projection=False),
            {"first_peck": 0.08102, "second_peck": 0.2269, "third_peck": 0.3730, "period": 0.1460, "descent": 0.0194},
            "Glocker & Studer 2005; trajectory published with the Siconos examples",
        ),
        Case(
            "slider_crank",
            "slider-crank with clearance in its guides: impacts, accumulation, sliding (user-defined system)",
            slider_crank,
            0.012,
            EventDriven(),
            {
                "first_impact": 0.002692503,
                "crank_before": 109.557682,
                "crank_after": 108.724580,
                "rod_before": -49.330790,
                "rod_after": -52.842290,
                "impulse": 0.1109260,
                "energy_before": 7.495548750,
                "energy_after": 7.4581385,
            },
            "Flores, Leine & Glocker 2010; numbers by a converged event-driven integration",
        ),
        Case(
            "impacting_bar",
            "elastic bar on a wall in the nodal coordinates of another code (user-defined system)",
            impacting_bar,
            748 * 2e-6,
            MoreauJean(step=2e-6, activation=0.0, gap_tolerance=0.0, projection=False),
            {"first_contact": 5.0401e-4, "last_contact": 8.8601e-4, "relative_impulse": 1.98551, "rebound": 0.098551},
            "trajectory published with the Siconos examples",
        ),
    )
