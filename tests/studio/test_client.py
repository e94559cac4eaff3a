"""viser's client page, as it is served."""

from __future__ import annotations

import gzip

import pytest

from evastudio.studio.client import client_page, style
from evastudio.studio.scheme import Scheme


def test_the_page_is_whole_compressed_and_tagged() -> None:
    page = client_page()
    assert gzip.decompress(page.compressed) == page.html
    assert len(page.compressed) < len(page.html)
    assert page.etag.startswith('"')
    assert page.etag.endswith('"')
    assert client_page() is page


@pytest.mark.parametrize("scheme", [None, *Scheme])
def test_the_style_that_hides_viser_controls_comes_before_the_page_body(
    scheme: Scheme | None,
) -> None:
    head, _ = client_page(scheme).html.decode().split("</head>", 1)
    assert style(scheme) in head
