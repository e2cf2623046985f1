"""Drives raxel from Python: set params, move the camera, run frames, read targets and buffers as arrays.

    import raxel

    with raxel.open("graphs/primary.toml", size=(640, 360)) as session:
        session.set("exposure", 2.0)
        session.step()
        depth = session.texels("depth")        # a numpy array, height × width × channels
        session.screenshot("a.png")

It speaks to `raxel control` through a pipe; docs/control.md has the protocol. Without numpy, arrays are memoryviews of the same shape.
`open_async` is the same for asyncio.
"""

from .aio import AsyncSession, open_async
from .requests import Disconnected, Picture, Refused
from .session import Session, open

__all__ = ["AsyncSession", "Disconnected", "Picture", "Refused", "Session", "open", "open_async"]
