"""A parser of the command line that names what was meant where a command, a choice or an option is mistyped."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from lcpflex.basics.names import meant

__all__ = ["Parser"]

LONGEST = 80  # characters of a word in a message


class Parser(argparse.ArgumentParser):
    """``argparse`` with the nearest name of commands, choices and options; sub-parsers are of the same kind."""

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse what is none of the choices, with the nearest of them."""
        if action.choices is None or value in action.choices:
            return
        choices = [str(choice) for choice in action.choices]
        text = str(value)[:LONGEST]
        raise argparse.ArgumentError(action, f"{text!r}{meant(text, choices)}; expected one of {', '.join(choices)}")

    def parse_args(self, args: Sequence[str] | None = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """As always, but for options that are not known, each told with the nearest one."""
        words = list(sys.argv[1:] if args is None else args)
        request, unknown = self.parse_known_args(words, namespace)
        if unknown:
            options = self._options_for(words)
            told = [f"{word[:LONGEST]!r}{meant(word.partition('=')[0][:LONGEST], options)}" for word in unknown]
            self.error(f"unrecognized arguments: {', '.join(told)}")
        return request

    def _options_for(self, words: Sequence[str]) -> list[str]:
        """The options of the command that was asked for."""
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction):
                for word in words:
                    if word in action.choices:
                        return list(action.choices[word]._option_string_actions)
        return list(self._option_string_actions)
