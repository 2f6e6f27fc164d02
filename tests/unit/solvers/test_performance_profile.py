"""Performance profiles: shares of problems solved within a factor of the best time."""

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.solvers.benchmark.profile import draw_profile, performance_profile
from tests import libs


class TestProfile:
    times = np.array([[1.0, 2.0, 3.0, np.inf], [2.0, 1.0, 3.0, np.inf], [4.0, np.inf, np.inf, np.inf]])

    def test_shares_by_hand(self):
        found = performance_profile(self.times, [1.0, 2.0, 4.0, 1e9])
        np.testing.assert_array_equal(found, [[0.5, 0.75, 0.75, 0.75], [0.5, 0.75, 0.75, 0.75], [0.0, 0.0, 0.25, 0.25]])

    def test_a_common_factor_of_time_changes_nothing(self):
        factors = np.geomspace(1.0, 8.0, 9)
        np.testing.assert_array_equal(
            performance_profile(self.times, factors), performance_profile(1024.0 * self.times, factors)
        )

    @pytest.mark.parametrize(
        ("times", "factors"),
        [
            (np.ones(3), [1.0]),
            (np.ones((0, 2)), [1.0]),
            (np.ones((2, 0)), [1.0]),
            (np.zeros((1, 1)), [1.0]),
            (np.full((1, 1), np.nan), [1.0]),
            (np.ones((1, 1)), [0.5]),
            (np.ones((1, 1)), [np.nan]),
            (np.ones((1, 1)), 2.0),
        ],
    )
    def test_refused(self, times, factors):
        with pytest.raises(ModelError, match=r"times|factors"):
            performance_profile(times, factors)

    def test_the_key_is_in_the_order_of_the_lines(self):
        (axes,) = draw_profile(
            ["b", "c", "a", "none"], np.vstack([self.times[[0, 2]], self.times[:1] / 2, _NEVER])
        ).axes
        assert [text.get_text() for text in axes.get_legend().get_texts()] == [
            "a, 75 %",
            "b, 75 %",
            "c, 25 %",
            "nothing:\nnone",
        ]

    def test_lines_are_the_profile(self):
        (axes,) = draw_profile(["a", "b", "c"], self.times).axes
        for line, expected in zip(axes.lines, performance_profile(self.times, [1.0, 3.0, 5.0]), strict=True):
            tau, share = line.get_data()
            found = [share[np.searchsorted(tau, at, side="right") - 1] for at in (1.0, 3.0, 5.0)]
            np.testing.assert_array_equal(found, expected)

    def test_no_two_lines_look_alike(self):
        (axes,) = draw_profile([str(i) for i in range(20)], 1.0 + np.arange(40.0).reshape(20, 2)).axes
        looks = {(libs.colors.to_hex(line.get_color()), line.get_marker()) for line in axes.lines}
        assert len(looks) == 20

    def test_nobody_solved_anything(self):
        (axes,) = draw_profile(["a", "b"], np.full((2, 3), np.inf)).axes
        assert not axes.lines
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["nothing:\na,\nb"]

    def test_a_solver_looks_the_same_in_all_charts(self):
        (first,), (second,) = (draw_profile(["a", "b", "c"], times).axes for times in (self.times, self.times[::-1]))

        def looks(axes):
            return {line.get_label()[0]: (line.get_color(), line.get_marker()) for line in axes.lines}

        assert looks(first) == looks(second)

    def test_names(self):
        with pytest.raises(ModelError, match="names has 1 entries: expected 3"):
            draw_profile(["a"], self.times)


_NEVER = np.full((1, 4), np.inf)
