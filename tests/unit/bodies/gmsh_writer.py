"""Files of Gmsh as its manual has them: format 2.2 or 4.1, text, or binary in either byte order."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

import numpy as np

NUMBERS = {"vertex": 15, "line": 1, "triangle": 2, "quad": 3, "tetra": 4, "hexahedron": 5, "wedge": 6, "pyramid": 7,
           "line3": 8, "triangle6": 9, "quad9": 10, "tetra10": 11, "hexahedron27": 12, "quad8": 16,
           "hexahedron20": 17}  # fmt: skip
DIMENSIONS = {"v": 0, "l": 1, "t": 2, "q": 2, "h": 3, "w": 3, "p": 3}


def dimension(kind):
    return 3 if kind.startswith("tetra") else DIMENSIONS[kind[0]]


@dataclass
class Sample:
    """Nodes by their numbers, elements (kind, rows of numbers of nodes, physical groups), names of groups."""

    tags: list
    places: np.ndarray
    blocks: list
    names: dict = field(default_factory=dict)  # (dimension, number): name

    def written(self, version, order):
        """The bytes of the file. version: "2.2" or "4.1". order: "" for text, "<" or ">"."""
        out = f"$MeshFormat\n{version} {int(bool(order))} 8\n".encode()
        out += struct.pack(order + "i", 1) + b"\n" if order else b""
        out += b"$EndMeshFormat\n"
        if self.names:
            lines = [f'{d} {n} "{name}"' for (d, n), name in self.names.items()]
            out += "\n".join(["$PhysicalNames", str(len(lines)), *lines, "$EndPhysicalNames", ""]).encode()
        parts = self._parts_2(order) if version == "2.2" else self._parts_4(order)
        for name, part in parts.items():
            out += f"${name}\n".encode() + part + f"\n$End{name}\n".encode()
        return out

    def _parts_2(self, order):
        nodes, elements, count = _Writer(order), _Writer(order), 0
        for tag, place in zip(self.tags, self.places, strict=True):
            nodes.put("i", tag).put("d", *place).line()
        for entity, (kind, rows, groups) in enumerate(self.blocks):
            for row in rows:
                for group in groups or [0]:  # once for each group
                    count += 1
                    head = (NUMBERS[kind], 1, 2) if order else (count, NUMBERS[kind], 2)
                    elements.put("i", *head, *([count] if order else []), group, entity + 1, *row).line()
        return {"Nodes": b"%d\n" % len(self.tags) + nodes.out, "Elements": b"%d\n" % count + elements.out}

    def _parts_4(self, order):
        entities, nodes, elements = _Writer(order), _Writer(order), _Writer(order)
        by_dimension = [[k for k, (kind, _, _) in enumerate(self.blocks) if dimension(kind) == d] for d in range(4)]
        entities.put("q", *map(len, by_dimension)).line()
        for d, numbers in enumerate(by_dimension):
            for k in numbers:
                groups = self.blocks[k][2]
                entities.put("i", k + 1).put("d", *[0.0] * (6 if d else 3)).put("q", len(groups)).put("i", *groups)
                entities.put(*(("q", 2) if d else ("q",))).put(*(("i", 1, -2) if d else ("i",))).line()
        half = len(self.tags) // 2
        nodes.put("q", 2, len(self.tags), min(self.tags), max(self.tags)).line()
        for some in (slice(0, half), slice(half, None)):
            nodes.put("i", 2, 1, 0).put("q", len(self.tags[some])).line()
            for tag in self.tags[some]:
                nodes.put("q", tag).line()
            for place in self.places[some]:
                nodes.put("d", *place).line()
        count = sum(len(rows) for _, rows, _ in self.blocks)
        elements.put("q", len(self.blocks), count, 1, count).line()
        number = 0
        for k, (kind, rows, _) in enumerate(self.blocks):
            elements.put("i", dimension(kind), k + 1, NUMBERS[kind]).put("q", len(rows)).line()
            for row in rows:
                number += 1
                elements.put("q", number, *row).line()
        return {"Entities": entities.out, "Nodes": nodes.out, "Elements": elements.out}


class _Writer:
    def __init__(self, order):
        self.order, self.out = order, b""

    def put(self, code, *values):
        if self.order:
            self.out += struct.pack(self.order + code * len(values), *values)
        else:
            self.out += (" ".join(repr(float(v)) if code == "d" else str(v) for v in values) + " ").encode()
        return self

    def line(self):
        self.out += b"" if self.order else b"\n"
