"""How the program is started."""

from __future__ import annotations

import os
from typing import Any, Mapping, Sequence

from .requests import Value, _plain

#: The program and its arguments.
Command = Sequence[str]


def command(
    file: str | os.PathLike[str] | None,
    size: Sequence[int],
    fps: float,
    world: str | os.PathLike[str] | None,
    sets: Mapping[str, Any] | None,
    binary: str | None,
    arguments: Sequence[str],
) -> Command:
    """The command that opens a session."""
    command = [binary or os.environ.get("RAXEL", "raxel"), "control", "--size", f"{size[0]}x{size[1]}", "--fps", str(fps)]
    if file is not None:
        command.append(os.fspath(file))
    if world is not None:
        command += ["--world", os.fspath(world)]
    for name, value in (sets or {}).items():
        command += ["--set", f"{name}={_text(value)}"]
    return [*command, *arguments]


def cannot_start(command: Command, error: OSError) -> OSError:
    """The same error with what to do."""
    message = f"`{command[0]}` cannot be started ({error.strerror}): put raxel on the path, or set RAXEL, e.g. to target/release/raxel"
    return type(error)(error.errno, message)


def _text(value: Value) -> str:
    value = _plain(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    return ",".join(map(str, value)) if isinstance(value, list) else str(value)
