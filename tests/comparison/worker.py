"""The process that runs scenes of one checkout: it takes a list of runs, and keeps each as soon as it is made.

Nothing of lcpflex is imported before the checkout stands first on the path, and nothing of it from anywhere else.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from pathlib import Path
from typing import Any

from tests.comparison.pairs import pairs_of
from tests.comparison.plan import STEPPERS, share_of
from tests.comparison.record import Record, file_of, kept, refused, save

__all__ = ["BEGINS", "FINISHED", "SCENES", "only_of", "work"]

BEGINS, FINISHED, SCENES = "begins", "finished", "scenes"  # first words of the lines that a worker writes
INTERVALS = 200  # between stored instants, in a run


def work(checkout: Path, folder: Path | None) -> None:
    """Tell the scenes of the checkout; with a folder, make the runs that stdin lists and keep them there."""
    lf = only_of(checkout)
    cases = lf.gallery.scenes()
    if folder is None:
        _tell(SCENES, json.dumps(list(cases)))
        return
    known: dict[str, dict[str, Any]] = {}
    for scene, stepper in json.load(sys.stdin):
        _tell(BEGINS, scene, stepper)
        began = time.process_time()
        record = _run(lf, cases[scene], stepper, known.setdefault(scene, {}))
        save(record, file_of(folder, scene, stepper))
        _tell(FINISHED, scene, stepper, f"{time.process_time() - began:.2f}")
    _refuse_strangers(checkout)


def only_of(checkout: Path) -> Any:
    """``lcpflex`` of that checkout, whichever is installed; ImportError with the path where it is another."""
    ours = Path(__file__).resolve().parents[2]
    sys.path[:] = [str(checkout), *(entry for entry in sys.path if Path(entry or ".").resolve() != ours)]
    # an editable installation has a finder of its own, which would give modules that the checkout has not
    sys.meta_path[:] = [finder for finder in sys.meta_path if not _finds_lcpflex(finder)]
    import lcpflex as lf
    import lcpflex.solvers

    assert lcpflex.solvers.__name__
    _refuse_strangers(checkout)
    return lf


def _finds_lcpflex(finder: Any) -> bool:
    module = str(getattr(finder, "__module__", ""))
    return module.startswith("__editable__") and "lcpflex" in module


def _refuse_strangers(checkout: Path) -> None:
    """Raise ImportError for a module of lcpflex that does not come from the checkout."""
    home = checkout.resolve()
    for name, module in list(sys.modules.items()):
        path = getattr(module, "__file__", None)
        if name.partition(".")[0] == "lcpflex" and path and home not in Path(path).resolve().parents:
            raise ImportError(f"{name} was imported from {path}; expected a file in {home}")


def _run(lf: Any, case: Any, stepper: str, known: dict[str, Any]) -> Record:
    """One run, however it ends."""
    duration = share_of(case, stepper) * case.duration
    asked = f"{duration:.9g} s"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the result has them
            scheme = STEPPERS[stepper](lf, case)
            asked = f"{asked} of {_brief(scheme)}"
            result = lf.simulate(case.build(), duration, scheme, record=duration / INTERVALS, progress=False)
            return kept(result, asked, lambda result: pairs_of(result, known))
    except lf.StepError as error:
        return kept(error.result, asked, lambda result: pairs_of(result, known), error)
    except lf.ModelError as error:
        return refused(error, asked)
    except Exception as error:  # whatever it is, it is part of what is compared
        return kept(None, asked, lambda result: [], error)


def _brief(scheme: Any) -> str:
    """Its class with its step or tolerance; all of its options may be more in one of two checkouts."""
    inner = getattr(scheme, "integrator", None)
    numbers = {
        name: getattr(part, name, None) for name in ("step", "rtol") for part in (inner, scheme) if hasattr(part, name)
    }
    told = ", ".join(f"{name}={value:.9g}" for name, value in numbers.items() if value is not None)
    return f"{type(scheme).__name__}({told})"


def _tell(*words: str) -> None:
    print(*words, sep="\t", flush=True)
