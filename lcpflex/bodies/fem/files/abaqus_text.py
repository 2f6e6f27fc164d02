"""The text of Abaqus input files: keywords, each with its parameters and the data lines behind it.

"*KEYWORD, parameter=value, flag" in any case; a line that ends with a comma goes on in the next; "**" begins a comment;
*INCLUDE and INPUT= put in other files, relative to the file that names them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from lcpflex.basics.arguments import LARGEST_TEXT
from lcpflex.bodies.fem.files.found import Unreadable
from lcpflex.errors import shown

__all__ = ["Keyword", "decoded", "keywords_of", "words_of"]

KEYWORD = re.compile(rb"^[ \t]*\*(?!\*)[^\n]*", re.MULTILINE)
COMMENT = re.compile(rb"^[ \t]*\*\*[^\n]*\n?", re.MULTILINE)
WORD = re.compile(r'\s*((?:[^,"]|"[^"]*")*)')  # up to a comma that is not in quotes
OTHERS = 1000  # files that one may put in, and how deep
DEPTH = 20
LONGEST = 4096  # characters of a keyword with its parameters
DATA = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "INSTANCE", "SYSTEM")  # whose data lines are read
BIG = (b"\xff\xfe", b"\xfe\xff")  # begin texts of two bytes a character


@dataclass(slots=True)
class Keyword:
    """A keyword in capitals, its parameters by their names in capitals, its data lines, and where it stands."""

    name: str
    options: dict[str, str]
    where: str
    data: list[bytes] = field(default_factory=list)

    def option(self, name: str) -> str:
        """A parameter that must be there."""
        if not self.options.get(name):
            raise Unreadable(f"*{self.name} {self.where} has no {name}, expected {name}=...")
        return self.options[name]

    def text(self) -> bytes:
        """Its data lines, without comments."""
        return b"\n".join(self.data)


@dataclass(slots=True)
class _Files:
    """What is read of a file and those it puts in."""

    folder: Path
    read: int = 0
    size: int = 0
    keywords: list[Keyword] = field(default_factory=list)


def keywords_of(path: Path) -> Iterator[Keyword]:
    """The keywords of a file, in order, with those of the files that it includes; raises Unreadable."""
    files = _Files(path.parent)
    _add_file(files, path, ())
    yield from files.keywords


def decoded(text: bytes) -> str:
    """A text in UTF-8, or as Western Europe wrote before."""
    try:
        return text.decode()
    except UnicodeDecodeError:
        return text.decode("latin-1")


def words_of(text: str) -> list[str]:
    """What commas divide, without white space around it or quotes; commas in quotes do not divide."""
    words, at = [], 0
    while at <= len(text):
        found = WORD.match(text, at)
        assert found is not None  # it matches nothing, too
        if found.end() < len(text) and text[found.end()] != ",":
            raise Unreadable(f"the line {shown(text)} has a quote without its twin, expected pairs")
        words.append(found[1].strip().replace('"', ""))
        at = found.end() + 1
    return words


def _add_file(files: _Files, path: Path, above: tuple[Path, ...]) -> None:
    data = _content(files, path, above)
    name = "" if not above else f" of {shown(path.name)}"
    at, line, counted = 0, 1, 0
    for found in KEYWORD.finditer(data):
        if found.start() < at:
            continue  # goes on a keyword that stands before
        _add_data(files, data[at : found.start()], name)
        line += data.count(b"\n", counted, found.start())
        counted = found.start()
        text, at = _whole(data, found.start(), found.end())
        keyword = _keyword(text, f"in line {line}{name}")
        if keyword.name == "INCLUDE":
            _add_file(files, _other(files, keyword, path), (*above, path))
            continue
        files.keywords.append(keyword)
        if keyword.name in DATA and "INPUT" in keyword.options:
            other = _other(files, keyword, path)
            _add_data(files, _content(files, other, (*above, path)), f" of {shown(other.name)}")
    _add_data(files, data[at:], name)


def _add_data(files: _Files, lines: bytes, name: str) -> None:
    """Data lines of the keyword before; those of keywords that have nothing of a mesh are dropped."""
    if b"**" in lines:
        lines = COMMENT.sub(b"", lines)
    if not lines or lines.isspace():
        return
    if not files.keywords:
        said = shown(decoded(lines.strip()[:40]))
        raise Unreadable(f"it begins with {said}{name}, expected a keyword of Abaqus (*NODE ...)")
    if files.keywords[-1].name in DATA:
        files.keywords[-1].data.append(lines)


def _content(files: _Files, path: Path, above: tuple[Path, ...]) -> bytes:
    """The bytes of a file, with "\\n" at the ends of its lines."""
    if path in above or len(above) > DEPTH:
        raise Unreadable(f"{shown(path.name)} includes itself, expected files that do not")
    files.read += 1
    if not path.is_file():
        raise Unreadable(f"it includes {shown(str(path))}, expected a file that is there")
    files.size += path.stat().st_size
    if files.read > OTHERS or files.size > LARGEST_TEXT:
        raise Unreadable(f"it includes more than {OTHERS} files or {LARGEST_TEXT:.0e} bytes, expected fewer")
    data = path.read_bytes()
    if data.startswith(BIG) or b"\0" in data[:1000]:
        raise Unreadable(f"{shown(path.name)} is no text of one byte a character, expected UTF-8")
    data = data.removeprefix(b"\xef\xbb\xbf")
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data


def _other(files: _Files, keyword: Keyword, path: Path) -> Path:
    """The file that INPUT= names: relative to the one that names it, or to the first."""
    name = keyword.option("INPUT")
    if "\0" in name or len(name) > LONGEST // 4:
        raise Unreadable(f"*{keyword.name} {keyword.where} names {shown(name)}, expected the name of a file")
    near = path.parent / name
    return near.resolve() if near.is_file() else (files.folder / name).resolve()


def _whole(data: bytes, start: int, end: int) -> tuple[bytes, int]:
    """The text of a keyword with the lines on which it goes on, and where its data begin."""
    text = data[start:end].rstrip()
    while text.endswith(b",") and end < len(data):
        begin, end = end + 1, data.find(b"\n", end + 1)
        end = len(data) if end < 0 else end
        text = (text + data[begin:end]).rstrip()
        if len(text) > LONGEST:
            break
    if len(text) > LONGEST:
        raise Unreadable(f"a keyword of {len(text)} characters, expected at most {LONGEST}")
    return text, min(end + 1, len(data))


def _keyword(text: bytes, where: str) -> Keyword:
    first, *rest = words_of(decoded(text).strip()[1:].rstrip(","))
    options = {}
    for word in rest:
        key, _, value = word.partition("=")
        options[key.strip().upper()] = value.strip()
    return Keyword(" ".join(first.upper().split()), options, where)
