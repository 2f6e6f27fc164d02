"""Run every scene of the gallery under every stepper in two checkouts, and say what differs.

    python tests/compare.py OLD NEW                         # all 665 runs, 100 seconds of computing for each checkout
    python tests/compare.py OLD NEW --scenes pendulum,stack --steppers own,event-driven
    python tests/compare.py OLD NEW --jobs 2 --keep FOLDER  # what was run stays, an npz file a run
    python tests/compare.py OLD NEW --list                  # which runs there are

OLD and NEW are folders of checkouts. Each is run by processes of its own that import lcpflex from it and from nowhere
else; what is run, and how, is that of the file at hand, not of OLD. Runs are shortened by a fixed share of the duration
where they cost much (:mod:`tests.comparison.plan`), by no clock, so that both checkouts make the same runs.

The table has a row a run, differences first:

died              its process ended, or it had no end within ``--seconds``
end changed       an error in one, none or another one in the other; a refusal alike
verdict changed   the last paragraph of the summary says otherwise, by more than numbers
asked differently the case has another duration or stepper
differs           in motion, in the total force or moment between two bodies, in energy, or in the number of steps
says otherwise    the same numbers with other warnings, notes or texts
equal to 1e-12    of what is usual in the run: rounding, or arrays that only tell of the computation
equal bits        all arrays, and all texts; "failed alike" and "refused alike" with the same message

Differences are shares: of places, of the extent of a body or of its travel; of velocities, forces, moments and
energies, of the largest in the run. Contact forces are summed over all touching points of two bodies before they are
compared, because many a split among these is not unique. Scenes that only one checkout has are listed.

Exit code: 0 where all is equal to the last bit, 1 where anything differs, 2 for arguments that cannot be.
"""

from __future__ import annotations

import sys
from pathlib import Path

if __name__ == "__main__":
    # `tests` is found from the folder of the checkout, and no file beside this one as a module of its own
    sys.path[0] = str(Path(__file__).resolve().parents[1])
    from tests.comparison.main import main

    sys.exit(main(sys.argv[1:]))
