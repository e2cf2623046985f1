"""A session: the process, and a method for each request."""

import base64
import json
import os
import pathlib
import subprocess
import tempfile

try:
    import numpy
except ImportError:  # Arrays are memoryviews then.
    numpy = None

# What a memoryview calls the types of the protocol.
_CODES = {"f4": "f", "u4": "I", "i4": "i", "u1": "B"}


class Refused(Exception):
    """A request that raxel did not do; nothing has changed."""

    def __init__(self, error, help):
        super().__init__("; ".join([error, *help]))
        self.error = error
        self.help = help


class Picture:
    """A picture that a notebook displays; `png` has the bytes of the file."""

    def __init__(self, png):
        self.png = png

    def _repr_png_(self):
        return self.png


class Disconnected(Exception):
    """The process has ended; the text is what it said on stderr."""


def open(file=None, *, size=(1280, 720), fps=60.0, world=None, sets=None, binary=None, cwd=None, arguments=()):
    """Opens a graph, a demo or a world; the project's graph when `file` is None.

    `binary` is the program, by default $RAXEL or `raxel` on the path. `cwd` is the folder to run it in, `arguments` are more of its
    arguments, `sets` are values of params by name.
    """
    command = [binary or os.environ.get("RAXEL", "raxel"), "control", "--size", f"{size[0]}x{size[1]}", "--fps", str(fps)]
    if file is not None:
        command.append(os.fspath(file))
    if world is not None:
        command += ["--world", os.fspath(world)]
    for name, value in (sets or {}).items():
        command += ["--set", f"{name}={_text(value)}"]
    return Session([*command, *arguments], cwd=cwd)


class Session:
    """A running raxel. Close it, or use it in a `with` block."""

    def __init__(self, command, cwd=None):
        # A file takes whatever is said; a pipe that nobody reads would be full one day, and stop the process.
        self._said = tempfile.TemporaryFile()
        try:
            self._process = subprocess.Popen(
                command, cwd=cwd, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said, text=True, encoding="utf-8"
            )
        except OSError as error:
            self._said.close()
            message = f"`{command[0]}` cannot be started ({error.strerror}): put raxel on the path, or set RAXEL, e.g. to target/release/raxel"
            raise type(error)(error.errno, message) from None
        self._id = 0
        #: Edits that were swapped in or found to be wrong, what passes have printed, what takes long, and what was said, in order, as raxel told them.
        self.events = []
        try:
            self._until("ready")
        except BaseException:
            self._process.kill()
            self.close()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Ends the process."""
        if self._process.poll() is None:
            try:
                self.ask("quit")
            except (Disconnected, OSError):
                pass
        try:
            self._process.stdin.close()
        except BrokenPipeError:  # closing writes what is left of a request that the process did not read
            pass
        self._process.stdout.close()
        self._process.wait()
        self._said.close()

    def ask(self, do, **fields):
        """Sends any request and gives the fields of its answer. Raises Refused when raxel does not do it."""
        self._id += 1
        request = {"id": self._id, "do": do, **{name: value for name, value in fields.items() if value is not None}}
        try:
            line = json.dumps(request, allow_nan=False, default=_plain)
        except ValueError:  # raxel could not tell whose answer it is: JSON has neither
            raise ValueError(f"`{do}` takes no NaN and no infinity") from None
        try:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
        except (BrokenPipeError, ValueError):
            self._ended()
        while True:
            answer = self._line()
            if "event" in answer:
                self.events.append(answer)
            elif answer["id"] == self._id:
                break
        if not answer["ok"]:
            raise Refused(answer["error"], answer.get("help", []))
        return {name: value for name, value in answer.items() if name not in ("id", "ok")}

    # What is open.

    def info(self):
        """Files, device, size, params, targets, buffers, passes and cameras."""
        return self.ask("info")

    def timings(self):
        """Milliseconds of GPU time of every pass in the last frame, by name; None for one that did not run."""
        return {entry["pass"]: entry["milliseconds"] for entry in self.ask("timings")["passes"]}

    def diagnostics(self):
        """What the last edit brought: `generation`, the one that is `showing`, and the `diagnostics` themselves."""
        return self.ask("diagnostics")

    def check_bounds(self, on=True):
        """Compiles the shaders with checks of their accesses, or without, and waits for them. `diagnostics()` has those out of bounds."""
        if self.ask("check_bounds", on=on)["compiles"]:
            self.wait_reload(60.0)

    def prints(self):
        """What passes have printed since the last call, a dict for each pass and frame: `pass`, `frame`, `lines` and `omitted`."""
        printed = [event for event in self.events if event["event"] == "printed"]
        self.events = [event for event in self.events if event["event"] != "printed"]
        return printed

    # What is driven.

    def set(self, param, value):
        """Sets a param and gives its value."""
        return self.ask("set", param=param, value=_plain(value))["value"]

    def unset(self, param):
        """Brings a param back to its default, and gives it."""
        return self.ask("unset", param=param)["value"]

    def target(self, target=""):
        """Chooses the debug target; the graph's own by default."""
        self.ask("target", target=target)

    def camera(self, name=None, *, position=None, look_at=None, yaw=None, pitch=None, fov=None):
        """Moves the camera (voxels, degrees), or only tells where it is."""
        position, look_at = (None if place is None else _plain(place) for place in (position, look_at))
        return self.ask("camera", name=name, position=position, look_at=look_at, yaw=yaw, pitch=pitch, fov=fov)

    def input(
        self,
        *,
        cursor=None,
        buttons=None,
        wheel=None,
        keys=None,
        gamepad_sticks=None,
        gamepad_triggers=None,
        gamepad_buttons=None,
        microphone=None,
        time_of_day=None,
    ):
        """Says what is held and turned from the next frame on; what is left out stays. An empty list is no cursor, no button, no key.
        `microphone` is a sound file of the project; an empty text is none.

        Returns all of it as a dict.
        """
        return self.ask(
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

    def record(self):
        """Starts over and records a take: what each frame is told."""
        self.ask("record")

    def stop(self, name=None):
        """Ends the take and writes it as a demo of the project. Returns `path`, `seconds` and why it `ended` early, or None."""
        return self.ask("stop", name=name)

    def step(self, frames=1):
        """Runs frames; gives the number and the time of the last."""
        return self.ask("step", frames=frames)

    def pause(self, paused=True):
        """Stops or starts the clock. While it is paused, frames run at the same time, and graphs that average over frames go on."""
        self.ask("pause", paused=paused)

    def seek(self, seconds):
        """Puts the next frame at that time."""
        self.ask("seek", seconds=seconds)

    def reset(self):
        """Starts over."""
        self.ask("reset")

    def edit(self, operations):
        """Edits the world, as one step: a list of dicts as `[[edits]]` of a demo, without times. Gives `chunks` and `steps`."""
        return self.ask("edit", operations=operations)

    def undo(self):
        """Takes the newest step of edits back. False when there is none."""
        return self.ask("undo")["undone"]

    def redo(self):
        """Makes the step again that was taken back last. False when there is none."""
        return self.ask("redo")["redone"]

    def resize(self, width, height):
        """Changes the extent of the output."""
        self.ask("resize", size=[width, height])

    def wait_reload(self, seconds=10.0):
        """Waits for the next edit; `reloaded` says whether it is running, `diagnostics` what is wrong otherwise."""
        return self.ask("wait_reload", seconds=seconds)

    # What is read.

    def capture(self):
        """Runs a frame and captures it by the RenderDoc that raxel runs under. Gives the file of the capture."""
        return self.ask("capture")["path"]

    def screenshot(self, path):
        """Writes the picture of the last frame; the extension says the form."""
        return self.ask("screenshot", path=os.fspath(path))

    def show(self):
        """The picture of the last frame as a `Picture`: a notebook displays it."""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "picture.png")
            self.screenshot(path)
            return Picture(path.read_bytes())

    def picture(self):
        """The picture of the last frame: height × width × 4 bytes, sRGB."""
        return _array(self.ask("picture"))

    def texels(self, target, *, age=0, mip=0, layer=0, after=None):
        """A target as numbers: height × width × channels of float32, uint32 or int32.

        `after` is a pass: `target("color,after=sky")` and `step()` before it take the copy that this reads.
        """
        return _array(self.ask("texels", target=target, age=age, mip=mip, layer=layer, after=after))

    def pixel(self, target, x, y, *, age=0, mip=0, layer=0, after=None):
        """The values of one texel; `after` as for `texels`."""
        values = self.ask("pixel", target=target, x=x, y=y, age=age, mip=mip, layer=layer, after=after)["values"]
        return [float(value) if isinstance(value, str) else value for value in values]

    def buffer(self, buffer, bytes, *, start=0, dtype=None):
        """Bytes of a buffer; with `dtype` (numpy's names, e.g. "f4") as an array."""
        data = base64.b64decode(self.ask("buffer", buffer=buffer, start=start, bytes=bytes)["data"])
        if dtype is None:
            return data
        if numpy is not None:
            return numpy.frombuffer(data, dtype="<" + dtype)
        return memoryview(data).cast(_CODES[dtype])

    def _line(self):
        line = self._process.stdout.readline()
        if not line:
            self._ended()
        return json.loads(line)

    def _until(self, event):
        while (line := self._line()).get("event") != event:
            self.events.append(line)

    def _ended(self):
        if self._said.closed:
            raise Disconnected("the session is closed")
        code = self._process.wait()
        self._said.seek(0)
        said = self._said.read().decode("utf-8", "replace")
        raise Disconnected(f"raxel has ended with exit code {code}: {said.strip()}")


def _array(answer):
    data = base64.b64decode(answer["data"])
    shape = [answer["height"], answer["width"], answer["channels"]]
    if numpy is not None:
        return numpy.frombuffer(data, dtype="<" + answer["type"]).reshape(shape)
    return memoryview(data).cast(_CODES[answer["type"]], shape=shape)


def _plain(value):
    """Numbers of any library as those of JSON."""
    if isinstance(value, (bool, int, float, str)):
        return value
    if hasattr(value, "tolist"):
        return value.tolist()
    return [_plain(part) for part in value]


def _text(value):
    value = _plain(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    return ",".join(map(str, value)) if isinstance(value, list) else str(value)
