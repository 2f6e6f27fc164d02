"""The command line: ``lcpflex`` or ``python -m lcpflex``."""

from __future__ import annotations

import argparse
import atexit
import gc
import os
import sys
from collections.abc import Sequence

from lcpflex import __version__
from lcpflex.cli.chart import add_chart
from lcpflex.cli.cross_check import add_cross_check
from lcpflex.cli.demo import add_demo
from lcpflex.cli.parser import Parser
from lcpflex.cli.right_size import add_right_size
from lcpflex.cli.run import add_gallery, add_run
from lcpflex.cli.stability import add_stability
from lcpflex.cli.warmup import add_warmup
from lcpflex.errors import LcpflexError, ModelError, StepError, ToleranceError

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Returns the exit code: 0 done, 1 the simulation failed or a solver claimed wrongly, 2 the request cannot be.
    """
    parser = _parser()
    atexit.register(gc.freeze)  # else Python looks three times through all of it when the process ends: .5 s
    thresholds = gc.get_threshold()
    gc.set_threshold(100_000)  # what a command loads and makes mostly stays: looking through it took a tenth of a demo
    try:
        return _carried_out(parser, arguments)
    finally:
        gc.set_threshold(*thresholds)


def _carried_out(parser: argparse.ArgumentParser, arguments: Sequence[str] | None) -> int:
    request = parser.parse_args(arguments)
    if request.command is None:
        parser.print_help()
        return 0
    try:
        return int(request.command(request))
    except ModelError as error:
        print(f"lcpflex: {error}", file=sys.stderr)
        return 2
    except LcpflexError as error:
        print(f"lcpflex: {error}", file=sys.stderr)
        if isinstance(error, StepError) and error.result is not None:
            print(f"\nUp to there:\n\n{error.result.summary()}", file=sys.stderr)
        if isinstance(error, ToleranceError) and error.result is not None:
            print(f"\nTried:\n\n{error.result.choice}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("lcpflex: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _parser() -> argparse.ArgumentParser:
    parser = Parser(prog="lcpflex", description="Frictional contact in flexible multibody systems.")
    parser.add_argument("--version", action="version", version=f"lcpflex {__version__}")
    parser.set_defaults(command=None)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    for add in (add_demo, add_gallery, add_run, add_cross_check, add_chart, add_right_size, add_stability, add_warmup):
        add(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())
