"""A session for asyncio."""

from __future__ import annotations

import asyncio
import os
from typing import Any, Mapping, NoReturn, Sequence

from .requests import Answer, Disconnected, Requests
from .start import Command, cannot_start, command

# Most bytes of an answer: a target of 16384×16384 texels has up to 4 GiB, and base64 takes a third more.
_LONGEST = 6 << 30


def open_async(
    file: str | os.PathLike[str] | None = None,
    *,
    size: Sequence[int] = (1280, 720),
    fps: float = 60.0,
    world: str | os.PathLike[str] | None = None,
    sets: Mapping[str, Any] | None = None,
    binary: str | None = None,
    cwd: str | os.PathLike[str] | None = None,
    arguments: Sequence[str] = (),
) -> AsyncSession:
    """A session for asyncio, which `async with` or `start` opens. The arguments are those of `open`."""
    return AsyncSession(command(file, size, fps, world, sets, binary, arguments), cwd=cwd)


class AsyncSession(Requests):
    """A raxel for asyncio. Use it in an `async with` block, or `start` and `close` it.

    Tasks may share a session: it sends one request after the other. If a task is cancelled while it waits, raxel carries its request out
    nevertheless.
    """

    def __init__(self, command: Command, cwd: str | os.PathLike[str] | None = None) -> None:
        super().__init__()
        self._command = command
        self._cwd = cwd
        self._process: asyncio.subprocess.Process | None = None

    async def __aenter__(self) -> AsyncSession:
        await self.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def start(self) -> None:
        """Starts the process, and waits until the session is open."""
        self._turn = asyncio.Lock()
        pipe = asyncio.subprocess.PIPE
        try:
            self._process = await asyncio.create_subprocess_exec(
                *self._command, cwd=self._cwd, stdin=pipe, stdout=pipe, stderr=self._said, limit=_LONGEST
            )
        except OSError as error:
            self._said.close()
            raise cannot_start(self._command, error) from None
        assert self._process.stdin is not None and self._process.stdout is not None
        self._requests, self._answers = self._process.stdin, self._process.stdout
        try:
            while not self._is_ready(await self._line()):
                pass
        except BaseException:
            if self._process.returncode is None:
                self._process.kill()
            await self.close()
            raise

    async def close(self) -> None:
        """Ends the process."""
        if self._process is not None and not self._said.closed:
            try:
                await self.ask("quit")
            except (Disconnected, OSError):
                pass
            self._requests.close()
            await self._process.wait()
        self._said.close()
        self._files.close()

    async def _answer(self, do: str, **fields: Any) -> Answer:
        self._must_be_open()
        if self._process is None:
            raise Disconnected("the session has not started: use it in `async with`, or await `start`")
        async with self._turn:
            self._requests.write(self._request(do, fields).encode())
            try:
                await self._requests.drain()
            except ConnectionError:
                await self._end(self._process)
            while (answer := self._take(await self._line())) is None:
                pass
            return answer

    async def _line(self) -> bytes:
        assert self._process is not None
        return await self._answers.readline() or await self._end(self._process)

    async def _end(self, process: asyncio.subprocess.Process) -> NoReturn:
        self._must_be_open()
        self._ended(await process.wait())
