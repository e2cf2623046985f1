"""A session that waits for each answer."""

from __future__ import annotations

import functools
import os
import subprocess
from typing import TYPE_CHECKING, Any, Callable, Coroutine, Mapping, NoReturn, Sequence, TypeVar

from .requests import Answer, Conversation, Disconnected, Requests
from .start import Command, cannot_start, command

if TYPE_CHECKING:
    from typing_extensions import Concatenate, ParamSpec

    P = ParamSpec("P")

T = TypeVar("T")


def open(
    file: str | os.PathLike[str] | None = None,
    *,
    size: Sequence[int] = (1280, 720),
    fps: float = 60.0,
    world: str | os.PathLike[str] | None = None,
    sets: Mapping[str, Any] | None = None,
    binary: str | None = None,
    cwd: str | os.PathLike[str] | None = None,
    arguments: Sequence[str] = (),
) -> Session:
    """Opens a graph, a demo or a world; the project's graph when `file` is None.

    `binary` is the program, by default $RAXEL or `raxel` on the path. `cwd` is the folder to run it in, `arguments` are more of its
    arguments, `sets` are values of params by name.
    """
    return Session(command(file, size, fps, world, sets, binary, arguments), cwd=cwd)


def _now(method: Callable[Concatenate[Any, P], Coroutine[Any, Any, T]]) -> Callable[Concatenate[Any, P], T]:
    """The same method without `await`: the `_answer` of a `Session` never suspends it."""

    @functools.wraps(method)
    def call(self: Any, /, *args: P.args, **kwargs: P.kwargs) -> T:
        try:
            method(self, *args, **kwargs).send(None)
        except StopIteration as done:
            value: T = done.value
            return value
        raise AssertionError(f"`{method.__name__}` was suspended")

    return call


class Session(Conversation):
    """A running raxel. Close it, or use it in a `with` block."""

    def __init__(self, command: Command, cwd: str | os.PathLike[str] | None = None) -> None:
        super().__init__()
        try:
            self._process = subprocess.Popen(
                command, cwd=cwd, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said, text=True, encoding="utf-8"
            )
        except OSError as error:
            self._said.close()
            raise cannot_start(command, error) from None
        assert self._process.stdin is not None and self._process.stdout is not None
        self._requests, self._answers = self._process.stdin, self._process.stdout
        try:
            while not self._is_ready(self._line()):
                pass
        except BaseException:
            self._process.kill()
            self.close()
            raise

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the process."""
        if self._process.poll() is None:
            try:
                self.ask("quit")
            except (Disconnected, OSError):
                pass
        try:
            self._requests.close()
        except BrokenPipeError:  # closing writes what is left of a request that the process did not read
            pass
        self._answers.close()
        self._process.wait()
        self._said.close()
        self._files.close()

    ask = _now(Requests.ask)
    info = _now(Requests.info)
    timings = _now(Requests.timings)
    diagnostics = _now(Requests.diagnostics)
    check_bounds = _now(Requests.check_bounds)
    writers = _now(Requests.writers)
    record_writes = _now(Requests.record_writes)
    set = _now(Requests.set)
    unset = _now(Requests.unset)
    target = _now(Requests.target)
    camera = _now(Requests.camera)
    input = _now(Requests.input)
    record = _now(Requests.record)
    stop = _now(Requests.stop)
    step = _now(Requests.step)
    pause = _now(Requests.pause)
    seek = _now(Requests.seek)
    reset = _now(Requests.reset)
    edit = _now(Requests.edit)
    undo = _now(Requests.undo)
    redo = _now(Requests.redo)
    resize = _now(Requests.resize)
    wait_reload = _now(Requests.wait_reload)
    files = _now(Requests.files)
    open = _now(Requests.open)
    presets = _now(Requests.presets)
    save_preset = _now(Requests.save_preset)
    apply_preset = _now(Requests.apply_preset)
    delete_preset = _now(Requests.delete_preset)
    write_params = _now(Requests.write_params)
    write_camera = _now(Requests.write_camera)
    undo_write = _now(Requests.undo_write)
    keys = _now(Requests.keys)
    move_key = _now(Requests.move_key)
    delete_key = _now(Requests.delete_key)
    write_key = _now(Requests.write_key)
    record_params = _now(Requests.record_params)
    loop = _now(Requests.loop)
    hand_back = _now(Requests.hand_back)
    display = _now(Requests.display)
    scale = _now(Requests.scale)
    fps_cap = _now(Requests.fps_cap)
    fly_speed = _now(Requests.fly_speed)
    brush = _now(Requests.brush)
    keep = _now(Requests.keep)
    forget = _now(Requests.forget)
    measure = _now(Requests.measure)
    compare = _now(Requests.compare)
    cancel = _now(Requests.cancel)
    capture = _now(Requests.capture)
    screenshot = _now(Requests.screenshot)
    show = _now(Requests.show)
    picture = _now(Requests.picture)
    texels = _now(Requests.texels)
    pixel = _now(Requests.pixel)
    statistics = _now(Requests.statistics)
    find = _now(Requests.find)
    buffer = _now(Requests.buffer)

    async def _answer(self, do: str, **fields: Any) -> Answer:
        line = self._request(do, fields)
        try:
            self._requests.write(line)
            self._requests.flush()
        except (BrokenPipeError, ValueError):
            self._end()
        while (answer := self._take(self._line())) is None:
            pass
        return answer

    def _line(self) -> str:
        return self._answers.readline() or self._end()

    def _end(self) -> NoReturn:
        self._must_be_open()
        self._ended(self._process.wait())
