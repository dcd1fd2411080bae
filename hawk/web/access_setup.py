"""Builds the tokens and logins of a server from its settings and its folder."""

from __future__ import annotations

from pathlib import Path

from hawk.web.access.access import AccessBook, OpenConnections
from hawk.web.access.access_keeper import AccessKeeper
from hawk.web.access.logins import Login, Logins
from hawk.web.access.tokens import TOKEN_FILE, Tokens, read_tokens, with_configured
from hawk.web.security import check_binding
from hawk.web.services import WebServices


def make_access(services: WebServices) -> tuple[AccessBook, AccessKeeper]:
    """Return tokens and logins, and what keeps them in step with their files; reads both files.

    Raises:
        InsecureBindingError: The address can be reached by others, and there is no operator's token.
        TokensError: The token file cannot be used.
    """

    def joined(kept: Tokens) -> Tokens:
        return with_configured(kept, services.web.token, services.cookie_secret)

    folder = services.folder
    tokens = joined(Tokens() if folder is None else read_tokens(folder / TOKEN_FILE))
    check_binding(services.web, tokens, (folder or Path("var")).resolve())
    logins = Logins(services.web, services.monotonic, services.cookie_secret)
    desk = services.side.desk

    def has_control(login: Login) -> bool:
        return desk.keeps_login(logins.control_secret(login))

    logins.has_control = has_control
    book = AccessBook(tokens, logins)
    keeper = AccessKeeper(folder, book, OpenConnections(book), joined, services.wall)
    keeper.restore()
    return book, keeper
