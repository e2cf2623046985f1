"""The requests of a session, and the lines that carry them, whatever sends them."""

from __future__ import annotations

import base64
import json
import os
import pathlib
import tempfile
from typing import IO, Any, Mapping, NoReturn, Sequence

from .files import Data, Exchange

try:
    import numpy
except ImportError:  # Arrays are memoryviews then.
    numpy = None  # type: ignore[assignment]

#: The fields of an answer.
Answer = dict[str, Any]

#: A numpy array; without numpy, a memoryview of the same shape.
Array = Any

#: A number, a boolean, a text, or a sequence or an array of numbers.
Value = Any

# What a memoryview calls the types of the protocol.
_CODES: dict[str, Any] = {"f4": "f", "u4": "I", "i4": "i", "u1": "B"}


class Refused(Exception):
    """A request that raxel did not do; nothing has changed."""

    def __init__(self, error: str, help: list[str]) -> None:
        super().__init__("; ".join([error, *help]))
        self.error = error
        self.help = help


class Disconnected(Exception):
    """The process has ended; the text is what it said on stderr."""


class Picture:
    """A picture that a notebook displays; `png` has the bytes of the file."""

    def __init__(self, png: bytes) -> None:
        self.png = png

    def _repr_png_(self) -> bytes:
        return self.png


class Conversation:
    """What has been asked and told."""

    def __init__(self) -> None:
        #: Edits that were swapped in or found to be wrong, what passes have printed, what takes long, and what was said, in order, as raxel told them.
        self.events: list[dict[str, Any]] = []
        self._id = 0
        # A file takes whatever is said; a pipe that nobody reads would be full one day, and stop the process.
        self._said: IO[bytes] = tempfile.TemporaryFile()
        # Where raxel puts the bytes of arrays.
        self._files = Exchange()

    def prints(self) -> list[dict[str, Any]]:
        """What passes have printed since the last call, a dict for each pass and frame: `pass`, `frame`, `lines` and `omitted`."""
        printed = [event for event in self.events if event["event"] == "printed"]
        self.events = [event for event in self.events if event["event"] != "printed"]
        return printed

    async def _answer(self, do: str, **fields: Any) -> Answer:
        """Sends a request and gives the fields of its answer."""
        raise NotImplementedError

    async def _read(self, do: str, **fields: Any) -> tuple[Answer, Data]:
        """Sends a request for bytes. They come in a file; where raxel cannot write one that is seen here, they come in the answer."""
        self._must_be_open()
        while (path := self._files.path()) is not None:
            try:
                answer = await self._answer(do, path=path, **fields)
            except Refused as refused:
                if path not in refused.error:
                    raise
                self._files.give_up(path)
                continue
            data = self._files.take(path)
            if data is not None:
                return answer, data
            self._files.give_up(path)
        answer = await self._answer(do, **fields)
        return answer, base64.b64decode(answer["data"])

    def _request(self, do: str, fields: dict[str, Any]) -> str:
        """The line of the next request."""
        self._id += 1
        request = {"id": self._id, "do": do, **{name: value for name, value in fields.items() if value is not None}}
        try:
            return json.dumps(request, allow_nan=False, default=_plain) + "\n"
        except ValueError:  # raxel could not tell whose answer it is: JSON has neither
            raise ValueError(f"`{do}` takes no NaN and no infinity") from None

    def _take(self, line: str | bytes) -> Answer | None:
        """The answer to the last request, if the line is one; an event is kept."""
        answer = json.loads(line)
        if "event" in answer:
            self.events.append(answer)
            return None
        if answer["id"] != self._id:  # nobody waits for it any more
            return None
        if not answer["ok"]:
            raise Refused(answer["error"], answer.get("help", []))
        return {name: value for name, value in answer.items() if name not in ("id", "ok")}

    def _is_ready(self, line: str | bytes) -> bool:
        """Whether the session is open; another event is kept."""
        event = json.loads(line)
        if event.get("event") == "ready":
            return True
        self.events.append(event)
        return False

    def _ended(self, code: int) -> NoReturn:
        self._said.seek(0)
        said = self._said.read().decode("utf-8", "replace")
        raise Disconnected(f"raxel has ended with exit code {code}: {said.strip()}")

    def _must_be_open(self) -> None:
        if self._said.closed:
            raise Disconnected("the session is closed")


class Requests(Conversation):
    """A method for each request. `AsyncSession` has them as they are, `Session` has them without `await`."""

    async def ask(self, /, do: str, **fields: Any) -> Answer:
        """Sends any request and gives the fields of its answer. Raises Refused when raxel does not do it."""
        return await self._answer(do, **fields)

    # What is open.

    async def info(self) -> Answer:
        """Files, device, size, params, targets, buffers, passes and cameras."""
        return await self._answer("info")

    async def timings(self) -> dict[str, float | None]:
        """Milliseconds of GPU time of every pass in the last frame, by name; None for one that did not run."""
        return {entry["pass"]: entry["milliseconds"] for entry in (await self._answer("timings"))["passes"]}

    async def diagnostics(self) -> Answer:
        """What the last edit brought: `generation`, the one that is `showing`, and the `diagnostics` themselves."""
        return await self._answer("diagnostics")

    async def check_bounds(self, on: bool = True) -> None:
        """Compiles the shaders with checks of their accesses, or without, and waits for them. `diagnostics()` has those out of bounds."""
        answer = await self._answer("check_bounds", on=on)
        if answer["compiles"]:
            await self._answer("wait_reload", seconds=60.0, after=answer["generation"])

    async def writers(self, target: str, x: int, y: int, *, mip: int = 0, layer: int = 0) -> list[Answer]:
        """The passes that may write a texel, each with its `writes` in the last frame that ran it: file, line, invocation, workgroup, values.

        The first call compiles the shaders with records of their writes. The writes are those of frames after the call with this texel.
        """
        await self.record_writes()
        return (await self._answer("writers", target=target, x=x, y=y, mip=mip, layer=layer))["passes"]

    async def record_writes(self, on: bool = True) -> None:
        """Compiles the shaders with records of their writes for `writers`, or without, and waits for them."""
        answer = await self._answer("record_writes", on=on)
        if answer["compiles"]:
            await self._answer("wait_reload", seconds=60.0, after=answer["generation"])

    # What is driven.

    async def set(self, param: str, value: Value) -> Value:
        """Sets a param and gives its value."""
        return (await self._answer("set", param=param, value=_plain(value)))["value"]

    async def unset(self, param: str) -> Value:
        """Brings a param back to its default, and gives it."""
        return (await self._answer("unset", param=param))["value"]

    async def target(self, target: str = "") -> None:
        """Chooses the debug target; the graph's own by default."""
        await self._answer("target", target=target)

    async def camera(
        self,
        name: str | None = None,
        *,
        position: Value = None,
        look_at: Value = None,
        yaw: float | None = None,
        pitch: float | None = None,
        fov: float | None = None,
    ) -> Answer:
        """Moves the camera (voxels, degrees), or only tells where it is."""
        position, look_at = (None if place is None else _plain(place) for place in (position, look_at))
        return await self._answer("camera", name=name, position=position, look_at=look_at, yaw=yaw, pitch=pitch, fov=fov)

    async def input(
        self,
        *,
        cursor: Sequence[int] | None = None,
        buttons: Sequence[str] | None = None,
        wheel: Value = None,
        keys: Sequence[str] | None = None,
        gamepad_sticks: Value = None,
        gamepad_triggers: Value = None,
        gamepad_buttons: Sequence[str] | None = None,
        microphone: str | None = None,
        time_of_day: float | None = None,
    ) -> Answer:
        """Says what is held and turned from the next frame on; what is left out stays. An empty list is no cursor, no button, no key.
        `microphone` is a sound file of the project; an empty text is none.

        Returns all of it as a dict.
        """
        return await self._answer(
            "input",
            cursor=cursor,
            buttons=buttons,
            wheel=wheel,
            keys=keys,
            gamepad_sticks=gamepad_sticks,
            gamepad_triggers=gamepad_triggers,
            gamepad_buttons=gamepad_buttons,
            microphone=microphone,
            time_of_day=time_of_day,
        )

    async def record(self) -> None:
        """Starts over and records a take: what each frame is told."""
        await self._answer("record")

    async def stop(self, name: str | None = None) -> Answer:
        """Ends the take and writes it as a demo of the project. Returns `path`, `seconds` and why it `ended` early, or None."""
        return await self._answer("stop", name=name)

    async def step(self, frames: int = 1) -> Answer:
        """Runs frames; gives the number and the time of the last."""
        return await self._answer("step", frames=frames)

    async def pause(self, paused: bool = True) -> None:
        """Stops or starts the clock. While it is paused, frames run at the same time, and graphs that average over frames go on."""
        await self._answer("pause", paused=paused)

    async def seek(self, seconds: float) -> None:
        """Puts the next frame at that time."""
        await self._answer("seek", seconds=seconds)

    async def reset(self) -> None:
        """Starts over."""
        await self._answer("reset")

    async def edit(self, operations: Sequence[dict[str, Any]]) -> Answer:
        """Edits the world, as one step: a list of dicts as `[[edits]]` of a demo, without times. Gives `chunks` and `steps`."""
        return await self._answer("edit", operations=operations)

    async def undo(self) -> bool:
        """Takes the newest step of edits back. False when there is none."""
        return bool((await self._answer("undo"))["undone"])

    async def redo(self) -> bool:
        """Makes the step again that was taken back last. False when there is none."""
        return bool((await self._answer("redo"))["redone"])

    async def resize(self, width: int, height: int) -> None:
        """Changes the extent of the output."""
        await self._answer("resize", size=[width, height])

    async def wait_reload(self, seconds: float = 10.0, *, after: int | None = None) -> Answer:
        """Waits for the next edit; `reloaded` says whether it is running, `diagnostics` what is wrong otherwise.

        With `after`, the `generation` of an answer, it waits for an edit that came after that answer, and that may be there already.
        """
        return await self._answer("wait_reload", seconds=seconds, after=after)

    # What the panels of the window do, too.

    async def files(self) -> list[dict[str, Any]]:
        """The graphs, worlds and demos of the project: dicts of `kind`, `path`, and whether it `runs`."""
        return list((await self._answer("files"))["files"])

    async def open(self, path: str, seconds: float = 60.0) -> Answer:
        """Opens a graph, a world or a demo in place of what runs, and waits for it. `opened` says whether it runs, `diagnostics` what is wrong."""
        return await self._answer("open", path=path, seconds=seconds)

    async def presets(self) -> dict[str, dict[str, list[float]]]:
        """The presets of the graph: by name, the components of each param."""
        return {preset["name"]: preset["values"] for preset in (await self._answer("presets"))["presets"]}

    async def save_preset(self, name: str) -> Answer:
        """Keeps the values of all params under a name; a preset of that name is replaced."""
        return await self._answer("save_preset", name=name)

    async def apply_preset(self, name: str) -> Answer:
        """Sets the params to the values of a preset. Gives those that `changed`, and those that the graph does not have (`left`)."""
        return await self._answer("apply_preset", name=name)

    async def delete_preset(self, name: str) -> Answer:
        """Takes a preset out of the file."""
        return await self._answer("delete_preset", name=name)

    async def write_params(self, params: Sequence[str], to: str = "own") -> Answer:
        """Writes the values of params into the graph's own file; with `to="declared"`, into the file that each default stands in."""
        return await self._answer("write_params", params=list(params), to=to)

    async def write_camera(self, name: str) -> Answer:
        """Writes the camera into the world's file under a name."""
        return await self._answer("write_camera", name=name)

    async def undo_write(self) -> list[str]:
        """Restores the files that were written last, and gives their paths; none if no file was written."""
        return list((await self._answer("undo_write"))["files"])

    async def keys(self) -> Answer:
        """The demo: `path`, `duration`, `seconds`, whether it `drives`, and the keys of its `tracks`."""
        return await self._answer("keys")

    async def move_key(self, track: str, key: int, to: float) -> Answer:
        """Writes another time of a key into the demo's file. A track has the name that `keys` gives it, and its first key is 0."""
        return await self._answer("move_key", track=track, key=key, to=to)

    async def delete_key(self, track: str, key: int) -> Answer:
        """Takes a key out of the demo's file."""
        return await self._answer("delete_key", track=track, key=key)

    async def write_key(self, param: str | None = None, *, seconds: float | None = None) -> Answer:
        """Writes the camera, or the value of a param, into the demo's file as a key: at this moment, or at a time."""
        return await self._answer("write_key", param=param, seconds=seconds)

    async def record_params(self, on: bool = True) -> Answer:
        """Begins to record params that `set` moves, over the frames; with `on=False`, writes the keys into the demo.

        Without a demo, raxel makes one and opens it. The second answer has its `path`, and the `tracks` with the number of their `keys`.
        """
        return await self._answer("record_params", on=on)

    async def loop(self, on: bool = True) -> None:
        """Starts the demo over at its end, or stays there."""
        await self._answer("loop", on=on)

    async def hand_back(self) -> None:
        """Lets the demo drive again what was set by hand."""
        await self._answer("hand_back")

    async def display(
        self, map: str | None = None, *, channel: int | None = None, range: Sequence[float] | None = None
    ) -> Answer:
        """Shows the shown target by another map, channel or range; without arguments, as the graph does."""
        return await self._answer("display", map=map, channel=channel, range=None if range is None else _plain(range))

    async def scale(self, scale: float) -> Answer:
        """Computes so many pixels for each pixel of the size, along each axis."""
        return await self._answer("scale", scale=scale)

    async def fps_cap(self, fps: int | None = None) -> int:
        """Bounds the frames a second of a window, or only gives the bound; 0 is none."""
        return int((await self._answer("fps_cap", fps=fps))["fps"])

    async def fly_speed(self, voxels: float | None = None) -> float:
        """Sets the voxels a second that the keys of a window fly, or only gives them."""
        return float((await self._answer("fly_speed", voxels=voxels))["voxels"])

    async def brush(
        self,
        *,
        effect: str | None = None,
        shape: str | None = None,
        size: int | None = None,
        height: int | None = None,
        material: str | None = None,
    ) -> Answer:
        """Changes the brush of a window; what is left out stays. An empty `material` is the one under the cursor.

        `effect` is "add", "subtract", "paint" or "pick", `shape` is "voxel", "box", "sphere" or "cylinder". Returns all of it.
        """
        return await self._answer("brush", effect=effect, shape=shape, size=size, height=height, material=material)

    async def keep(self, *, path: str | os.PathLike[str] | None = None, target: str | None = None) -> str:
        """Keeps what is shown, to compare with it; or the picture in a file, or a target as it goes on. Gives its name."""
        return str((await self._answer("keep", path=None if path is None else os.fspath(path), target=target))["kept"])

    async def forget(self) -> None:
        """Lets go of the kept picture."""
        await self._answer("forget")

    async def measure(self) -> Mapping[str, Any]:
        """How far the shown target is from the kept picture: `flip`, `rmse`, `max`, and the pixels that are `differing` of all `pixels`."""
        found = await self._answer("measure")
        return {name: float(value) if name in ("flip", "rmse", "max") else value for name, value in found.items()}

    async def compare(self, mode: str | None = None, *, gain: float | None = None, flipped: bool | None = None) -> None:
        """Shows the kept picture in the window: `mode` is "off", "wipe" or "difference", `flipped` shows it alone."""
        await self._answer("compare", mode=mode, gain=gain, flipped=flipped)

    async def cancel(self) -> bool:
        """Gives up the pass that the window's device has worked on for long. False when it does not work for long."""
        return bool((await self._answer("cancel"))["cancelled"])

    # What is read.

    async def capture(self) -> str:
        """Runs a frame and captures it by the RenderDoc that raxel runs under. Gives the file of the capture."""
        return str((await self._answer("capture"))["path"])

    async def screenshot(self, path: str | os.PathLike[str]) -> Answer:
        """Writes the picture of the last frame; the extension says the form."""
        return await self._answer("screenshot", path=os.fspath(path))

    async def show(self) -> Picture:
        """The picture of the last frame as a `Picture`: a notebook displays it."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "picture.png")
            await self._answer("screenshot", path=os.fspath(path))
            return Picture(path.read_bytes())

    async def picture(self) -> Array:
        """The picture of the last frame: height × width × 4 bytes, sRGB."""
        return _array(*await self._read("picture"))

    async def texels(self, target: str, *, age: int = 0, mip: int = 0, layer: int = 0, after: str | None = None) -> Array:
        """A target as numbers: height × width × channels of float32, uint32 or int32.

        `after` is a pass: `target("color,after=sky")` and `step()` before it take the copy that this reads.
        """
        return _array(*await self._read("texels", target=target, age=age, mip=mip, layer=layer, after=after))

    async def pixel(
        self, target: str, x: int, y: int, *, age: int = 0, mip: int = 0, layer: int = 0, after: str | None = None
    ) -> list[float]:
        """The values of one texel; `after` as for `texels`."""
        values = (await self._answer("pixel", target=target, x=x, y=y, age=age, mip=mip, layer=layer, after=after))["values"]
        return [float(value) if isinstance(value, str) else value for value in values]

    async def statistics(self, target: str, *, age: int = 0, mip: int = 0, layer: int = 0, after: str | None = None) -> Answer:
        """Counts, range, mean, percentiles and histogram of each channel, in the list `channels`; `after` as for `texels`."""
        return await self._answer("statistics", target=target, age=age, mip=mip, layer=layer, after=after)

    async def find(
        self,
        target: str,
        value: str,
        *,
        channel: int = 0,
        start: Mapping[str, int] | None = None,
        forward: bool = True,
        age: int = 0,
        mip: int | None = None,
        layer: int | None = None,
        after: str | None = None,
    ) -> dict[str, int] | None:
        """The `mip`, `layer`, `x` and `y` of the next texel that is "nan", "infinite", "smallest" or "largest"; None if there is none.

        Without `mip` and `layer`, all of them are searched. The search begins after the place `start`, which an earlier call gave.
        """
        fields = {"channel": channel, "from": start, "forward": forward, "age": age, "mip": mip, "layer": layer, "after": after}
        found = (await self._answer("find", target=target, value=value, **fields))["found"]
        return None if found is None else dict(found)

    async def buffer(self, buffer: str, bytes: int, *, start: int = 0, dtype: str | None = None) -> Array:
        """Bytes of a buffer; with `dtype` (numpy's names, e.g. "f4") as an array."""
        _, data = await self._read("buffer", buffer=buffer, start=start, bytes=bytes)
        if dtype is None:
            return memoryview(data).tobytes()
        if numpy is not None:
            return numpy.frombuffer(data, dtype="<" + dtype)
        return memoryview(data).cast(_CODES[dtype])


def _array(answer: Answer, data: Data) -> Array:
    shape = [answer["height"], answer["width"], answer["channels"]]
    if numpy is not None:
        return numpy.frombuffer(data, dtype="<" + answer["type"]).reshape(shape)
    return memoryview(data).cast(_CODES[answer["type"]], shape=shape)


def _plain(value: Value) -> Any:
    """Numbers of any library as those of JSON."""
    if isinstance(value, (bool, int, float, str)):
        return value
    if hasattr(value, "tolist"):
        return value.tolist()
    return [_plain(part) for part in value]
