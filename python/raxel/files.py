"""Files that bring the bytes of arrays from raxel: much faster than text in an answer."""

from __future__ import annotations

import mmap
import os
import pathlib
import tempfile
from typing import Union

#: Bytes, in memory or in a file that has no name any more.
Data = Union[bytes, mmap.mmap]


class Exchange:
    """A folder for files that raxel writes and that are read here once: in memory where there is such a folder, else on the disk."""

    def __init__(self) -> None:
        # The last one is tried first.
        self._places: list[str | None] = [None, "/dev/shm"] if os.path.isdir("/dev/shm") else [None]
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._count = 0

    def path(self) -> str | None:
        """The path of the next file; None where files do not go between raxel and this program."""
        while self._folder is None:
            if not self._places:
                return None
            try:
                self._folder = tempfile.TemporaryDirectory(prefix="raxel-", dir=self._places[-1])
            except OSError:
                self._places.pop()
        self._count += 1
        return os.path.join(self._folder.name, f"{self._count}.bin")

    def give_up(self, path: str) -> None:
        """Raxel cannot write into the folder of this file: it is full, or on another machine. The next one is tried."""
        if self._folder is not None and os.path.dirname(path) == self._folder.name:
            self.close()
            self._places.pop()

    def take(self, path: str) -> Data | None:
        """The bytes of a file, which goes away; None if it is not there. A change of them changes no file."""
        try:
            with open(path, "rb") as file:
                whole = os.name == "posix" and os.fstat(file.fileno()).st_size > 0
                data: Data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY) if whole else file.read()
        except OSError:
            return None
        pathlib.Path(path).unlink(missing_ok=True)
        return data

    def close(self) -> None:
        """Removes the folder."""
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None
