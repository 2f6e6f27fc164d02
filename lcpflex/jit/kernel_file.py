"""One compiled kernel as a file: its machine code, what that calls, and what numba must know of it.

The name of a file is the key of its kernel (:mod:`lcpflex.jit.keys`); there is no index. It is written under another
name and then put in its place, so that readers find it whole or not at all; a hash over all of it tells damage.
"""

from __future__ import annotations

import hashlib
import json
import os
import uuid
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from lcpflex.jit.cache_folders import is_private_file, is_safe

__all__ = ["ENDING", "KernelFile", "read", "write"]

ENDING = ".kernel"
MAGIC = b"lcpflex kernel 1\n"
DIGEST = 32  # bytes of the hash
LENGTH = 8  # bytes that tell how long the header is
LARGEST = 256 * 2**20  # of all files in a folder [bytes]; beyond it, the oldest half goes


@dataclass(frozen=True)
class KernelFile:
    """What is kept of a kernel.

    Attributes
    ----------
    key
        Of the kernel.
    big
        Whether callers call it; a small one they take in.
    symbols
        The functions by which it is called.
    needs
        The functions of other kernels that its code calls, and the keys of these kernels.
    late
        Its calls of late kernels, and what they call.
    outside
        Further symbols that its code refers to: of libm, of Python, of numba.
    defined
        The symbols that the code defines.
    code
        Object code for the linker of LLVM; empty where ``entry`` has it.
    entry
        What a caller that is compiled, and Python, must know: pickled.
    """

    key: str
    big: bool
    symbols: tuple[str, ...]
    needs: dict[str, str]
    late: dict[str, str]
    outside: tuple[str, ...]
    defined: tuple[str, ...]
    code: bytes
    entry: bytes

    def packed(self) -> bytes:
        """As bytes."""
        names = ("key", "big", "symbols", "needs", "late", "outside", "defined")
        header = json.dumps({**{name: getattr(self, name) for name in names}, "code": len(self.code)}).encode()
        rest = len(header).to_bytes(LENGTH, "little") + header + self.code + self.entry
        return MAGIC + hashlib.sha256(rest).digest() + rest

    @staticmethod
    def unpacked(data: bytes, key: str) -> KernelFile | None:
        """From bytes; None where they are damaged, or of another kernel."""
        start = len(MAGIC) + DIGEST
        digest, rest = data[len(MAGIC) : start], data[start:]
        if not data.startswith(MAGIC) or hashlib.sha256(rest).digest() != digest:
            return None
        header_end = LENGTH + int.from_bytes(rest[:LENGTH], "little")
        header = json.loads(rest[LENGTH:header_end])
        code_end = header_end + header.pop("code")
        header |= {name: tuple(header[name]) for name in ("symbols", "outside", "defined")}
        found = KernelFile(**header, code=rest[header_end:code_end], entry=rest[code_end:])
        return found if found.key == key else None


def read(key: str, folders: Iterable[Path]) -> KernelFile | None:
    """The kernel of a key from the first folder that has it whole, and that is to be trusted."""
    for folder in folders:
        path = folder / (key + ENDING)
        try:
            if path.exists() and is_safe(folder) and is_private_file(str(path)):
                found = KernelFile.unpacked(path.read_bytes(), key)
                if found is not None:
                    return found
        except OSError:  # gone in the meantime, or not for us
            pass
    return None


def write(file: KernelFile, folder: Path) -> None:
    """Keep a kernel in a folder.

    Raises
    ------
    OSError
        Where it cannot be: a full disk, a folder that is gone.
    """
    path = folder / (file.key + ENDING)
    whole = folder / f"{file.key}.tmp.{uuid.uuid4().hex[:16]}"
    try:
        with os.fdopen(os.open(whole, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644), "wb") as opened:
            opened.write(file.packed())
        os.replace(whole, path)
    except BaseException:
        whole.unlink(missing_ok=True)
        raise


def thin_out(folder: Path, largest: int = LARGEST) -> None:
    """Delete the oldest kernels of a folder that has grown too large: of former versions, mostly."""
    kept = []
    for path in folder.glob("*" + ENDING):
        try:
            found = path.stat()
        except OSError:
            continue
        kept.append((found.st_mtime, found.st_size, path))
    size = sum(entry[1] for entry in kept)
    if size <= largest:
        return
    for _, own, path in sorted(kept):
        if size <= largest // 2:
            return
        try:
            path.unlink()
        except OSError:  # of another user, or open on Windows
            continue
        size -= own
