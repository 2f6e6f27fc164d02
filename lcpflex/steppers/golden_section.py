"""Golden sections: where a function of one variable is lowest between two places, with one look a time."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import kernel
from lcpflex.jit.struct import struct

__all__ = ["LOOKS", "Section", "begin_section", "narrow", "next_place"]

GOLDEN = 0.6180339887498949
LOOKS = 41  # until the section is a part in 1e8 of where it began


@struct
class Section:
    """Between a and b it is lowest; c < d are where it was, or is to be, looked at."""

    a: float
    b: float
    c: float
    d: float
    f_c: float
    f_d: float
    at_d: int  # 1 where d is next, 0 where c is
    both: int  # 1 before the first look


@kernel
def begin_section(section: Section, low: float, high: float) -> None:
    """All of (low, high)."""
    section.a = low
    section.b = high
    section.c = high - GOLDEN * (high - low)
    section.d = low + GOLDEN * (high - low)
    section.f_c = math.inf
    section.f_d = math.inf
    section.at_d = 0
    section.both = 1


@kernel
def next_place(section: Section) -> float:
    """Where to look next."""
    return section.d if section.at_d == 1 else section.c


@kernel
def narrow(section: Section, f: float) -> None:
    """Take what was found there into account."""
    if section.at_d == 1:
        section.f_d = f
    else:
        section.f_c = f
    if section.both == 1:
        section.both = 0
        section.at_d = 1
    elif section.f_c < section.f_d:
        section.b = section.d
        section.d = section.c
        section.f_d = section.f_c
        section.c = section.b - GOLDEN * (section.b - section.a)
        section.at_d = 0
    else:
        section.a = section.c
        section.c = section.d
        section.f_c = section.f_d
        section.d = section.a + GOLDEN * (section.b - section.a)
        section.at_d = 1
