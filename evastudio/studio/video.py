"""A run as a video: MP4, painted picture by picture.

Written by PyAV, which is the extra `evastudio[video]`; nothing else of evastudio needs it.
"""

from __future__ import annotations

import tempfile
from fractions import Fraction
from pathlib import Path

from evastudio.learning.cleaning import Progress, silent
from evastudio.live.footage import frame_count, frames
from evastudio.live.reel import Reel
from evastudio.studio.painter import Painter

FPS = 30
QUALITY = {"crf": "20", "preset": "veryfast"}
"""Of x264: its constant rate factor, the lower the better, and how hard it tries to be small."""


def video(
    reel: Reel,
    camera: str | None,
    size: tuple[int, int],
    fps: int = FPS,
    progress: Progress = silent,
) -> bytes:
    """The run in `reel` seen through `camera`, `size` its width and height, both even: an MP4 file.

    What `films.check` raises was raised before.
    """
    import av  # a server that makes no films need not load it

    painter = Painter(reel.scene, *size)
    count = frame_count(reel, fps)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "video.mp4"
        # Its index comes first, so that a browser plays it while it still loads.
        with av.open(str(path), "w", options={"movflags": "+faststart"}) as container:
            stream = container.add_stream("libx264", rate=fps, options=QUALITY)
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
