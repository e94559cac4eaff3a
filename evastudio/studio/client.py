"""viser's browser client, as the studio serves it."""

from __future__ import annotations

import gzip
import hashlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import viser

from evastudio.studio.scheme import Scheme

STYLE = """
<style>
html, body { background: %s; }
[data-dock-root] > :not(:has(canvas)), :has([data-dock-root]) ~ .mantine-Paper-root,
.mantine-Notifications-root { display: none !important; }
.picking canvas { cursor: crosshair; }
html:not([data-mantine-color-scheme=%s]) body { visibility: hidden; }
</style>
"""
"""The page around the view has the controls, so viser's own are hidden; those of narrow views lie
beside what the others are in. viser begins white, so a dark view is shown once it is told so."""
GROUND = {None: "#07090f", Scheme.DARK: "#080b14", Scheme.LIGHT: "#e9edf5"}
"""What is seen before anything is drawn."""


@dataclass(frozen=True)
class ClientPage:
    """One HTML file that holds the whole client."""

    html: bytes
    compressed: bytes
    """`html` after gzip."""
    etag: str
    """Quoted, as the header wants it."""


def style(scheme: Scheme | None) -> str:
    """What the client's page looks like in that scheme."""
    return STYLE % (GROUND[scheme], scheme or Scheme.DARK)


@cache
def client_page(scheme: Scheme | None = None) -> ClientPage:
    """The client of the installed viser, its panels hidden, for a page in that scheme."""
    source = Path(viser.__file__).parent / "client" / "build" / "index.html"
    html = (
        source.read_text(encoding="utf-8").replace("</head>", f"{style(scheme)}</head>", 1).encode()
    )
    digest = hashlib.sha256(html).hexdigest()[:32]
    return ClientPage(html, gzip.compress(html, mtime=0), f'"{digest}"')
