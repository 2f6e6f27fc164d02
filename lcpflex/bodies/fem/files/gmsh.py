"""Files of Gmsh, formats 2.2 and 4.1, as text or binary in either byte order.

A file is a list of sections, "$Name" to "$EndName"; those that hold no mesh are passed over
(https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

import numpy as np

from lcpflex.bodies.fem.files import gmsh_2, gmsh_4
from lcpflex.bodies.fem.files.found import CELLS, FoundMesh, Part, Unreadable, grouped
from lcpflex.bodies.fem.files.gmsh_cells import Elements, Names, Nodes, merged_twins
from lcpflex.bodies.fem.files.gmsh_data import element_data
from lcpflex.bodies.fem.files.gmsh_numbers import BinaryNumbers, TextNumbers
from lcpflex.bodies.fem.files.numbering import Numbering, joined
from lcpflex.errors import shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["is_gmsh", "read_gmsh"]

STARTS = (b"$MeshFormat", b"$NOD", b"$Comments", b"$PhysicalNames")  # of its files; $NOD: format 1
SECTION = re.compile(rb"^[ \t]*\$([A-Za-z]+)[ \t]*\r?$", re.MULTILINE)
PHYSICAL_NAME = re.compile(rb'^\s*(\d+)\s+(-?\d+)\s+"(.*)"\s*$')
VERSION_2 = re.compile(r"2(\.[0-2]0*)?")  # Netgen writes "2.000000"
ONCE = ("MeshFormat", "PhysicalNames", "Entities", "Nodes", "Elements")


def is_gmsh(head: bytes) -> bool:
    """Whether a file that begins like this is one of Gmsh."""
    return head.lstrip().startswith(STARTS)


@dataclass(slots=True)
class _File:
    """A file while it is read."""

    data: bytes
    at: int = 0
    version: int = 0  # 2 or 4
    binary: bool = False
    order: str = "<"
    size: int = 8  # bytes of sizes in format 4.1
    names: Names = field(default_factory=dict)
    entities: dict[tuple[int, int], list[int]] | None = None
    nodes: Nodes | None = None
    elements: Elements | None = None
    stored: list[tuple[str, IntArray, FloatArray]] = field(default_factory=list)


def read_gmsh(data: bytes, source: str) -> FoundMesh:
    """The mesh in the bytes of a file; raises Unreadable for anything else.

    source: what the mesh is called in messages.
    """
    file = _File(data)
    seen: set[str] = set()
    while (start := SECTION.search(data, file.at)) is not None:
        name = start[1].decode()
        file.at = min(start.end() + 1, len(data))
        if not seen and name == "NOD":
            raise Unreadable("its format is Gmsh's 1, expected 2.2 or 4.1 (in Gmsh: save as version 4.1)")
        if name in ONCE and name in seen:
            raise Unreadable(f"it has two sections ${name}, expected one")
        if name in ONCE[1:] and "MeshFormat" not in seen:
            raise Unreadable(f"${name} comes before $MeshFormat, expected that first")
        seen.add(name)
        _read_section(file, name)
    if file.nodes is None or file.elements is None:
        missing = [name for name in ("MeshFormat", "Nodes", "Elements") if name not in seen]
        raise Unreadable(f"it has no section ${missing[0]}, expected one{_told(file, seen)}")
    return _mesh_of(file, file.nodes, file.elements, source)


def _told(file: _File, seen: set[str]) -> str:
    if "ParametricNodes" in seen:
        return "; nodes with parameters are not read (in Gmsh: Mesh.SaveParametric = 0)"
    return ""


def _read_section(file: _File, name: str) -> None:
    if name == "MeshFormat":
        _read_format(file)
    elif name == "PhysicalNames":
        file.names = _names(_text(file, name))
    elif name == "Entities" and file.version == 4:
        numbers = _numbers(file, name)
        file.entities = gmsh_4.entities(numbers)
        _finish(file, numbers)
    elif name == "PartitionedEntities":
        raise Unreadable("its mesh is partitioned, expected a whole one (in Gmsh: unpartition it before it is saved)")
    elif name == "Nodes":
        file.nodes = _read_nodes(file)
    elif name == "Elements":
        file.elements = _read_elements(file)
    elif name == "ElementData":
        found = element_data(_text(file, name), file.order if file.binary else "")
        if found is not None:
            file.stored.append(found)
    else:
        _text(file, name)  # nothing of the mesh
    _close(file, name)


def _read_format(file: _File) -> None:
    end = file.data.find(b"\n", file.at)
    words = file.data[file.at : end if end >= 0 else len(file.data)].decode(errors="replace").split()
    if len(words) != 3 or end < 0:
        raise Unreadable(f"$MeshFormat has {shown(' '.join(words))}, expected a version, 0 or 1, and a size")
    version, kind, size = words
    if VERSION_2.fullmatch(version):
        file.version = 2
    elif version == "4.1":
        file.version = 4
    else:
        raise Unreadable(f"its format is Gmsh's {shown(version)}, expected 2.2 or 4.1 (in Gmsh: save as version 4.1)")
    if kind not in ("0", "1") or size not in (("8",) if file.version == 2 else ("4", "8")):
        raise Unreadable(f"$MeshFormat has {shown(' '.join(words))}, expected {version}, 0 (text) or 1 (binary), and 8")
    file.binary, file.size, file.at = kind == "1", int(size), end + 1
    if not file.binary:
        return
    one = file.data[file.at : file.at + 4]
    orders = {(1).to_bytes(4, "little"): "<", (1).to_bytes(4, "big"): ">"}
    if one not in orders:
        raise Unreadable(f"$MeshFormat has the bytes {one.hex()}, expected the number 1 in either byte order")
    file.order, file.at = orders[one], file.at + 4


def _text(file: _File, name: str) -> bytes:
    """What stands before the end of the section, to which the file is put."""
    end = file.data.find(b"$End" + name.encode(), file.at)
    if end < 0:
        raise Unreadable(f"it ends in ${name}, expected $End{name}")
    text = file.data[file.at : end]
    file.at = end
    return text


def _close(file: _File, name: str) -> None:
    """Pass by the end of the section, which stands here."""
    ending = b"$End" + name.encode()
    rest = file.data[file.at : file.at + len(ending) + 8].lstrip()
    if not rest.startswith(ending):
        raise Unreadable(f"${name} does not end where it tells, expected $End{name} there")
    file.at = file.data.index(ending, file.at) + len(ending)


def _numbers(file: _File, name: str, whole: bool = False) -> TextNumbers | BinaryNumbers:
    return _bytes(file, name) if file.binary else TextNumbers(_text(file, name), f"${name}", whole)


def _bytes(file: _File, name: str) -> BinaryNumbers:
    return BinaryNumbers(file.data, file.at, file.order, file.size, f"${name}")


def _line_count(file: _File, name: str) -> int:
    """The count on a line of its own before the bytes, in format 2.2."""
    end = file.data.find(b"\n", file.at)
    line = file.data[file.at : max(end, file.at)][:40].strip()
    if not line.isdigit():
        raise Unreadable(f"${name} begins with {shown(line.decode(errors='replace'))}, expected a number of entries")
    file.at = end + 1
    return int(line)


def _read_nodes(file: _File) -> Nodes:
    if file.version == 2 and file.binary:
        count = _line_count(file, "Nodes")
        taken = _bytes(file, "Nodes")
        nodes = gmsh_2.binary_nodes(taken, count)
        file.at = taken.at
        return nodes
    numbers = _numbers(file, "Nodes")
    nodes = gmsh_2.text_nodes(numbers) if file.version == 2 else gmsh_4.nodes(numbers)
    _finish(file, numbers)
    return nodes


def _read_elements(file: _File) -> Elements:
    if file.version == 2 and file.binary:
        count = _line_count(file, "Elements")
        taken = _bytes(file, "Elements")
        elements = gmsh_2.binary_elements(taken, count)
        file.at = taken.at
        return elements
    if file.version == 2:
        return gmsh_2.text_elements(_text(file, "Elements"))
    numbers = _numbers(file, "Elements", whole=True)
    elements = gmsh_4.elements(numbers, file.entities)
    _finish(file, numbers)
    return elements


def _finish(file: _File, numbers: TextNumbers | BinaryNumbers) -> None:
    if isinstance(numbers, BinaryNumbers):
        file.at = numbers.at
    else:
        numbers.check_end()


def _names(text: bytes) -> Names:
    """Names of physical groups by dimension and number, in the order of the file."""
    lines = [line for line in text.splitlines() if line.strip()]
    names: Names = {}
    for line in lines[1:]:
        found = PHYSICAL_NAME.match(line)
        if found is None:
            said = shown(line.decode(errors="replace"))
            raise Unreadable(f"$PhysicalNames has the line {said}, expected a dimension, a number and a name in quotes")
        names[int(found[1]), abs(int(found[2]))] = _decoded(found[3])
    if not lines or not lines[0].strip().isdigit() or int(lines[0][:20]) != len(lines) - 1:
        raise Unreadable(f"$PhysicalNames has {len(lines) - 1} names, expected as many as it tells")
    return names


def _decoded(name: bytes) -> str:
    try:
        return name.decode()
    except UnicodeDecodeError:
        return name.decode("latin-1")


def _mesh_of(file: _File, nodes: Nodes, elements: Elements, source: str) -> FoundMesh:
    numbering = Numbering(nodes.numbers, "node")
    blocks = [
        (block.kind, numbering.known(block.cells, f"element {block.numbers[0] if len(block.numbers) else 0} or later"))
        for block in elements
    ]
    parts: list[Part] = [
        (file.names.get((CELLS[kind].dimension, tag), str(tag)), kind, cells[chosen])
        for (kind, cells), block in zip(blocks, elements, strict=True)
        for tag, chosen in block.physical
    ]
    if file.version == 4:  # groups with names in the order of their list
        rank = {name: k for k, name in enumerate(file.names.values())}
        parts.sort(key=lambda part: rank.get(part[0], len(rank)))
    tags = _stored(file, elements)
    if file.version == 2:
        blocks, tags = merged_twins(blocks, tags)
    groups = grouped({}, [parts], {kind for kind, cells in blocks if len(cells)})
    return FoundMesh(nodes.places, blocks, groups, source, tags)


def _stored(file: _File, elements: Elements) -> dict[str, list[FloatArray]]:
    """Numbers of the elements of each block; those of elements that are not named are zero."""
    if not file.stored:
        return {}
    numbering = Numbering(joined([block.numbers for block in elements]), "element")
    ends = np.cumsum([len(block.numbers) for block in elements])[:-1]
    tags: dict[str, list[FloatArray]] = {}
    for name, numbers, values in file.stored:
        every = np.zeros(numbering.count)
        every[numbering.known(numbers, name)] = values
        tags[name] = np.split(every, ends)
    return tags
