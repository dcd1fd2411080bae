"""Errors of a page."""

from __future__ import annotations

from playwright.async_api import Page

BUSY = "503 (Service Unavailable)"
"""The page asks a busy drone or desk again (api.ts): what it does not show then is found without this."""


class Errors(list[str]):
    """Errors of the page."""


def watch(page: Page) -> Errors:
    """Collect the page's errors, but for those of a computer that others keep busy."""
    errors = Errors()

    def note(kind: str, text: str) -> None:
        if kind == "error" and BUSY not in text:
            errors.append(text)

    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda message: note(message.type, message.text))
    return errors
