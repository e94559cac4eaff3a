"""A run as a film: MP4, painted picture by picture.

Written by PyAV, which is the extra `evastudio[video]`; nothing else of evastudio needs it.
"""

from __future__ import annotations

import tempfile
from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path

from evastudio.errors import ConflictError
from evastudio.learning.cleaning import Progress, silent
from evastudio.live.footage import frame_count, frames
from evastudio.live.reel import Reel
from evastudio.studio.painter import Painter

SIZE = (1280, 720)
FPS = 30
QUALITY = "20"
"""x264's constant rate factor: the lower the better."""


def ready() -> None:
    """Raise ConflictError where no film can be written."""
    if find_spec("av") is None:
        raise ConflictError(
            "Films are written by PyAV, which is not installed. Install it with: "
            "pip install 'evastudio[video]'. A page (.html) needs nothing."
        )


def video(
    reel: Reel,
    camera: str | None,
    size: tuple[int, int] = SIZE,
    fps: int = FPS,
    progress: Progress = silent,
) -> bytes:
    """The run in `reel` seen through `camera`, `size` its width and height, both even: an MP4 file.

    Raises ConflictError where PyAV is not installed.
    """
    ready()
    import av  # a server that makes no films need not load it

    painter = Painter(reel.scene, *size)
    count = frame_count(reel, fps)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "video.mp4"
        # Its index comes first, so that a browser plays it while it still loads.
        with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
            stream = container.add_stream("libx264", rate=fps, options={"crf": QUALITY})
            stream.width, stream.height = size
            stream.pix_fmt = "yuv420p"
            stream.time_base = Fraction(1, fps)
            for number, (moment, seen_from) in enumerate(frames(reel, camera, fps)):
                frame = av.VideoFrame.from_ndarray(painter.paint(moment, seen_from), format="rgb24")
                frame.pts = number
                container.mux(stream.encode(frame))
                progress(number / count, f"Picture {number + 1} of {count}")
            container.mux(stream.encode(None))
        return path.read_bytes()
