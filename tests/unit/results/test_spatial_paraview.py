"""Files for ParaView of spatial results: surfaces where the bodies are, with their velocities."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from tests import libs
from tests.spatial_scenes import soft_body, thrown

pytestmark = pytest.mark.skipif(find_spec("h5py") is None, reason="needs h5py")


def test_surfaces_and_points_move_with_their_bodies(tmp_path: Path) -> None:
    result = lf.simulate(thrown(), 0.02, lf.MoreauJean(step=1e-3), record=0.005)
    path = result.to_vtkhdf(tmp_path / "run.vtkhdf")
    with libs.h5py.File(path) as file:
        root = file["VTKHDF"]
        m, count = len(result.times), int(root["NumberOfPoints"][0])
        places = root["Points"][...].reshape(m, count, 3)
        rates, bent = (root["PointData"][name][...].reshape(m, count, 3) for name in ("velocity", "deflection"))
        owner = root["CellData"]["body"][...]
        types, offsets, ids = (root[name][...] for name in ("Types", "Offsets", "Connectivity"))
    assert set(types[owner == 0]) == {5}
    assert np.count_nonzero(owner == 0) == 12
    assert set(types[owner == 2]) == {1}

    def points_of(body: int) -> np.ndarray:
        return np.unique(np.concatenate([ids[offsets[c] : offsets[c + 1]] for c in np.flatnonzero(owner == body)]))

    box, ball, soft = (points_of(b) for b in range(3))
    assert len(box) == 8
    corners = result.compiled.layout.shapes[0].vertices  # type: ignore[union-attr]
    for k, corner in zip(box, corners, strict=True):
        np.testing.assert_allclose(places[:, k], result.point("box", tuple(corner)), atol=1e-14)
        np.testing.assert_allclose(rates[:, k], result.velocity("box", tuple(corner)), atol=1e-13)
    away = np.linalg.norm(places[:, ball] - result.point("ball", "center")[:, None], axis=2)
    np.testing.assert_allclose(away, 0.1, rtol=1e-12)
    for i, k in enumerate(soft):
        np.testing.assert_allclose(places[:, k], result.point("soft", str(i)), atol=1e-14)
        np.testing.assert_allclose(rates[:, k], result.velocity("soft", str(i)), atol=1e-13)
    eta = result.q[:, result.modes_of("soft").columns]
    deflections = result.orientation("soft")[0].apply(np.einsum("k,kni->ni", eta[0], soft_body().shapes))
    np.testing.assert_allclose(bent[0, soft], deflections, atol=1e-14)
    assert not bent[:, box].any()
