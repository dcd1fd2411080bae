"""Errors of a page."""

from __future__ import annotations

from playwright.async_api import Page


class Errors(list[str]):
    """Errors of the page."""


def watch(page: Page) -> Errors:
    """Collect the page's errors."""
    errors = Errors()
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    return errors
