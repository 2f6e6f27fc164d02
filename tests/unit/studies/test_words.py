"""Studies say how far they have come, with the words of the run that is under way."""

from __future__ import annotations

import pytest

import lcpflex as lf
from lcpflex.basics import progress
from tests.scenes import disc_on_floor


def test_a_stability_map(always: pytest.LogCaptureFixture) -> None:
    lf.studies.stability(
        lambda height: disc_on_floor(height), {"moreau": lf.MoreauJean(1e-3)}, {"height": [0.11, 0.12]}, 0.05
    )
    assert any(line.startswith("stability after 0 s: 0 of 2 cells done; t = ") for line in always.messages)
    assert any("1 of 2 cells done" in line for line in always.messages)


def test_work_and_precision(always: pytest.LogCaptureFixture) -> None:
    lf.studies.work_precision(
        lambda: disc_on_floor(0.11), {"moreau": [lf.MoreauJean(2e-3), lf.MoreauJean(1e-3)]}, duration=0.05, repeats=0,
        outputs=["motion"],
    )  # fmt: skip
    lines = [line for line in always.messages if line.startswith("work_precision after 0 s: 0 of 1 scenes done")]
    assert any("runs done, now moreau; t = " in line for line in lines)


def test_a_study_in_silence(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """With progress=False, of its runs as well; by default all is seen where logging is not set up."""
    monkeypatch.setattr(progress, "EVERY", 0.0)
    monkeypatch.setattr(progress, "now", lambda: 0.0)
    monkeypatch.setattr(progress.LOGGER, "hasHandlers", lambda: False)
    for shown in (False, None):
        lf.studies.stability(
            lambda height: disc_on_floor(height), {"m": lf.MoreauJean(1e-3)}, {"height": [0.11]}, 0.05, progress=shown
        )
        assert ("lcpflex: stability after 0 s" in capsys.readouterr().err) == (shown is None)
