"""A run as a page: one HTML file that plays it in 3D in any browser, with nothing beside it."""

from __future__ import annotations

import asyncio
import html
from contextlib import closing

from evastudio.learning.cleaning import Progress, silent
from evastudio.live.footage import frame_count, frames
from evastudio.live.reel import Reel
from evastudio.studio.view import View

FPS = 30
STYLE = """
<style>
html, body { background: #07090f; }
.mantine-Notifications-root { display: none !important; }
</style>
"""


def recorded(
    reel: Reel, camera: str | None, title: str, fps: int = FPS, progress: Progress = silent
) -> bytes:
    """The run in `reel` seen through `camera`, as an HTML file in UTF-8.

    It holds viser's own client, which plays what a view would have been sent.
    """
    loop = asyncio.new_event_loop()  # it never runs: nobody is connected
    with closing(loop), closing(View(reel.scene, loop)) as view:
        recording = view.recording()
        count = frame_count(reel, fps)
        for number, (moment, seen_from) in enumerate(frames(reel, camera, fps)):
            view.show(moment, fresh=number == 0, camera=seen_from)
            recording.insert_sleep(1.0 / fps)
            progress(0.9 * number / count, f"Picture {number + 1} of {count}")
        page = recording.as_html(dark_mode=True)
    head = f"<title>{html.escape(title)}</title>{STYLE}"
    return page.replace("<title>Viser</title>", head, 1).encode()
