"""Arrows and numbers of contact forces in pictures of space."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.results.drawn_forces import draw_arrows
from lcpflex.results.spatial.camera import camera_of
from lcpflex.results.spatial.contact_arrows import ContactArrows
from tests import libs
from tests.unit.results.drawn import SIDE, sliding


def test_arrows_are_the_forces_on_the_body_in_the_picture() -> None:
    """Of equal scale: they sum up to m g cos(tilt) (n - mu t), whose part across the camera is seen."""
    tilt = 0.4
    result = sliding(tilt)
    camera = camera_of(SIDE, np.array([0.0, 0.0, -9.81]))
    figure = result.draw(0.02, view=SIDE)
    arrows = [one for one in figure.axes[0].texts if isinstance(one, libs.Annotation) and one.arrow_patch is not None]
    ends = np.array([np.subtract(one.xy, one.xyann) for one in arrows])
    key, seen = ends[0], ends[1:]
    assert len(seen) == 4
    scale = float(next(one.get_text() for one in figure.axes[0].texts if one.get_text().endswith("N  ")).split()[0])
    total = seen.sum(axis=0) * scale / np.linalg.norm(key)
    turned = Rotation.from_rotvec([0.0, tilt, 0.0])
    expected = 2.0 * 9.81 * np.cos(tilt) * turned.apply([-0.1, 0.0, 1.0])
    np.testing.assert_allclose(total, camera.seen(expected)[:2], rtol=1e-6, atol=1e-6)


def test_numbers_of_forces_do_not_hide_each_other() -> None:
    """Nine that are cut, from almost one place: those that have room are beside their tips, the largest first."""
    figure, ax = libs.plt.subplots()
    ax.set_xlim(0.0, 1.0)
    ax.set_ylim(0.0, 1.0)
    draw_arrows(ax, [(np.array([0.5, 0.1]), np.array([0.5 + 1e-3 * k, 0.5]), 100.0 + k, True) for k in range(8)])
    figure.canvas.draw()
    words = [text for text in ax.texts if text.get_text().strip()]
    assert 2 <= len(words) <= 6
    assert words[0].get_text().strip() == "110 N"
    boxes = [text.get_window_extent() for text in words]
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:k])
    libs.plt.close(figure)


def test_of_two_bodies_the_later_one_has_the_arrow_whatever_was_declared_first() -> None:
    for turned in (False, True):
        scene = lf.SpatialScene()
        low = scene.add(lf.Cuboid(0.2, 0.2, 0.2, mass=3.0), "low", position=(0.0, 0.0, 0.1))
        high = scene.add(lf.Sphere(0.1, mass=1.0), "high", position=(0.0, 0.0, 0.3))
        pair = (high, low) if turned else (low, high)
        scene.contact(*(body.surface() for body in pair))
        scene.contact(scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), low.surface())
        result = lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3))
        assert result.compiled is not None
        arrows = ContactArrows(result, result.compiled, {0: 0.2, 1: 0.2})
        arrows.measure(1.0)
        found = arrows.at(len(result.times) - 1)
        assert len(found) == 5
        assert all(arrow.tip[2] > arrow.foot[2] for arrow in found)
        assert max(arrow.force for arrow in found) == pytest.approx(9.81)
        lengths = [np.linalg.norm(arrow.tip - arrow.foot) / arrow.force for arrow in found if not arrow.cut]
        np.testing.assert_allclose(lengths, arrows.length / arrows.usual, rtol=1e-12)


def test_arrows_stay_within_the_picture() -> None:
    result = sliding(0.4)
    axes = result.draw(0.02).axes[0]
    tips = np.array([one.xy for one in axes.texts if isinstance(one, libs.Annotation) and one.arrow_patch is not None])
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert (tips > [left, low]).all()
    assert (tips < [right, high]).all()
