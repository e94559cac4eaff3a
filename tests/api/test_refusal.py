"""Whoever opens an address in a browser reads a page where a program gets a problem."""

from __future__ import annotations

from typing import TYPE_CHECKING

import httpx

from evastudio.api.refusal import POLICY

if TYPE_CHECKING:
    from conftest import Studio

BROWSER = {"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"}


def test_a_stranger_reads_what_to_do(studio: Studio) -> None:
    answer = httpx.get(f"{studio.base}/", headers=BROWSER, trust_env=False)
    assert answer.status_code == 401
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    assert answer.headers["content-security-policy"] == POLICY
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert "Open the address that the studio printed" in answer.text
    assert "Bearer" not in answer.text
    assert "<a " not in answer.text


def test_who_is_in_is_led_on_from_an_address_that_leads_nowhere(studio: Studio) -> None:
    answer = studio.client.get("/nothing/<i>here</i>", headers=BROWSER)
    assert answer.status_code == 404
    assert '<a href="/">To the studio</a>' in answer.text
    assert "<i>" not in answer.text
    view = studio.client.get("/view/1/light/", headers=BROWSER)
    assert view.status_code == 404
    assert view.headers["content-security-policy"] == POLICY


def test_programs_get_problems(studio: Studio) -> None:
    for headers in ({}, {"Accept": "application/json"}):
        answer = studio.client.get("/nothing/here", headers=headers)
        assert answer.headers["content-type"] == "application/problem+json"
        assert answer.json()["status"] == 404
