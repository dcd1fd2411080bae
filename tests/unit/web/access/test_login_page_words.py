"""The login page speaks the browser's language."""

from __future__ import annotations

import re
from dataclasses import fields

import aiohttp
import pytest

from hawk.comm.protocol.authority import Role
from hawk.web.access.guesses import FREE_GUESSES
from hawk.web.access.login_page import ENGLISH, FRENCH, LoginWords, login_words
from tests.unit.web.stand import Stand


@pytest.mark.parametrize(
    ("accepted", "words"),
    [
        ("fr", FRENCH),
        ("fr-CA,en;q=0.8", FRENCH),
        ("en-GB,fr;q=0.9", ENGLISH),
        ("de, en;q=0.5, fr;q=0.7", FRENCH),
        ("en;q=0, FR;q=0.1", FRENCH),
        ("fr;q=0", ENGLISH),
        ("fr;q=nonsense", ENGLISH),
        ("frp, *;q=0.5", ENGLISH),
        ("", ENGLISH),
        (";;,,q=", ENGLISH),
    ],
)
def test_the_language_is_the_most_wanted_one_that_is_known(accepted: str, words: LoginWords) -> None:
    assert login_words(accepted) is words


def test_every_word_is_translated() -> None:
    same = [field.name for field in fields(LoginWords) if getattr(ENGLISH, field.name) == getattr(FRENCH, field.name)]
    assert not same


async def form(stand: Stand, language: str, fill: dict[str, str] | None = None) -> str:
    """Return the text of the login page, or of its answer to a filled-in form."""
    assert stand.rig.server is not None
    url = stand.rig.server.make_url("/login")
    session: aiohttp.ClientSession = await stand.browser(headers={"Accept-Language": language})
    method = "GET" if fill is None else "POST"
    async with session.request(method, url, data=fill, headers={"Origin": str(url.origin())}) as response:
        return await response.text()


async def test_the_form_is_french_where_french_is_wanted(stand: Stand) -> None:
    text = await form(stand, "fr-FR,fr;q=0.9,en;q=0.8")
    assert '<html lang="fr">' in text
    assert "Se connecter" in text
    shown = re.sub(r"<[^>]*>|\s+", " ", text)
    for field in ("title", "role_note", "token_note", "log_in"):
        assert getattr(FRENCH, field) in shown
        assert getattr(ENGLISH, field) not in shown
    english = await form(stand, "en")
    assert '<html lang="en">' in english
    assert "Log in" in english


async def test_messages_are_french_and_one_that_is_not_translated_is_marked(stand: Stand) -> None:
    wrong = {"username": "operator", "password": "guess-number-00000001"}
    text = await form(stand, "fr", wrong)
    assert f'<p class="bad" role="alert" lang="fr">{FRENCH.wrong}</p>' in text
    assert FRENCH.incomplete in await form(stand, "fr", {"username": "nobody", "password": "x"})
    for number in range(FREE_GUESSES):
        await form(stand, "fr", {**wrong, "password": f"guess {number}"})
    text = await form(stand, "fr", {"username": "operator", "password": stand.tokens[Role.OPERATOR]})
    assert '<p class="bad" role="alert" lang="en">Too many wrong tokens' in text
