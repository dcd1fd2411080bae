"""The login page, logging in and logging out.

The page has no script: it works with a password manager, and under the strict Content-Security-Policy.
"""

from __future__ import annotations

import html
from dataclasses import asdict, dataclass
from http import HTTPStatus
from pathlib import Path
from string import Template
from typing import Final
from urllib.parse import parse_qs

from aiohttp import hdrs, web

from hawk.comm.protocol.authority import Role
from hawk.web.access.access import KEEPER, OPEN, Access, access_of
from hawk.web.access.admission import BEARER, Admission
from hawk.web.access.guesses import is_loopback_peer
from hawk.web.access.proxied import forwarding_header, is_secure, place

WRONG: Final = "This is not the token of that role."
INCOMPLETE: Final = "Write operator or viewer as the role, and its token."


@dataclass(frozen=True, slots=True)
class LoginWords:
    """The page in one language. Roles are typed in English in every one."""

    language: str
    """Of the attribute ``lang``."""
    title: str
    role: str
    role_note: str
    role_hint: str
    token: str
    token_note: str
    log_in: str
    open_line: str
    wrong: str = WRONG
    incomplete: str = INCOMPLETE

    def message(self, text: str) -> tuple[str, str]:
        """Return a message of the server in this language, and the language in which it really is."""
        known = {WRONG: self.wrong, INCOMPLETE: self.incomplete}
        return (known[text], self.language) if text in known else (text, "en")


ENGLISH: Final = LoginWords(
    language="en",
    title="Log in",
    role="Role",
    role_note="operator acts, viewer watches",
    role_hint="operator or viewer",
    token="Token",  # noqa: S106 - a label
    token_note="of that role, as hawk-drone tokens rotate printed it",  # noqa: S106 - words
    log_in="Log in",
    open_line="This connection is not encrypted: others on this network can read the token.",
)
FRENCH: Final = LoginWords(
    language="fr",
    title="Connexion",
    role="Rôle",
    role_note="operator agit, viewer regarde",
    role_hint="operator ou viewer",
    token="Jeton",  # noqa: S106 - a label
    token_note="de ce rôle, tel que hawk-drone tokens rotate l’a affiché",  # noqa: S106 - words
    log_in="Se connecter",
    open_line="Cette connexion n’est pas chiffrée\u00a0: d’autres sur ce réseau peuvent lire le jeton.",
    wrong="Ce n’est pas le jeton de ce rôle.",
    incomplete="Écrivez operator ou viewer comme rôle, et son jeton.",
)
_SPOKEN: Final = {words.language: words for words in (ENGLISH, FRENCH)}


def login_words(accepted: str) -> LoginWords:
    """Return the words in the language that a browser wants most.

    Args:
        accepted: The header ``Accept-Language`` (RFC 9110, 12.5.4), such as ``fr-CA, en;q=0.8``; what cannot be read of
            it counts as not wanted.
    """
    wanted = sorted((_weighed(each) for each in accepted.split(",")), key=lambda pair: -pair[1])
    known = (_SPOKEN.get(language) for language, weight in wanted if weight > 0)
    return next((words for words in known if words is not None), ENGLISH)


def _weighed(preference: str) -> tuple[str, float]:
    """Return a language without its region, in small letters, and its weight, 0 to 1."""
    tag, _, weight = preference.partition(";")
    language = tag.strip().lower().split("-")[0]
    try:
        return language, float(weight.strip().removeprefix("q=")) if weight else 1.0
    except ValueError:
        return language, 0.0


FOLDER: Final = Path(__file__).parent / "login"
LOGIN: Final = "/login"
PUBLIC: Final = frozenset({LOGIN, "/login.css", "/api/alive"})
"""Paths that are answered without a token."""
LARGEST_FORM_BYTES: Final = 4096
FORM_HEADERS: Final = {
    # with no-referrer a browser sends "Origin: null" with a form, and the server could not recognise its own page
    "Referrer-Policy": "same-origin",
    "Content-Security-Policy": "default-src 'none'; style-src 'self'; form-action 'self'; base-uri 'none'; "
    "frame-ancestors 'none'",
    hdrs.CACHE_CONTROL: "no-store",
}


class LoginPage:
    """Serves the page and its form; read before the loop is busy."""

    def __init__(self, admission: Admission) -> None:
        self._admission = admission
        self._page = Template((FOLDER / "login.html").read_text(encoding="utf-8"))
        self._style = (FOLDER / "login.css").read_text(encoding="utf-8")

    def add_routes(self, app: web.Application) -> None:
        """Add the routes of this module."""
        app.router.add_get(LOGIN, self.show)
        app.router.add_post(LOGIN, self.log_in)
        app.router.add_get("/login.css", self.style)
        app.router.add_post("/logout", self.log_out)
        app.router.add_get("/api/session", session)

    async def show(self, request: web.Request) -> web.StreamResponse:
        """Show the form; one who is logged in goes on to the page."""
        if not self._admission.asks_for_token or self._admission.by_login(request) is not None:
            return web.Response(status=303, headers={hdrs.LOCATION: place(request, "/")})
        return self.answer(request)

    def answer(
        self, request: web.Request, status: int = 200, message: str = "", role: str = "operator"
    ) -> web.Response:
        """Return the form in the browser's language, with a message above it."""
        words = login_words(request.headers.get(hdrs.ACCEPT_LANGUAGE, ""))
        said, language = words.message(message)
        is_near = is_loopback_peer(request.remote) and forwarding_header(request) is None
        is_open_line = not is_secure(request) and not is_near
        text = self._page.substitute(
            {name: html.escape(value) for name, value in asdict(words).items()},
            message=f'<p class="bad" role="alert" lang="{language}">{html.escape(said)}</p>' if message else "",
            note=f'<p class="warn">{html.escape(words.open_line)}</p>' if is_open_line else "",
            typed_role=html.escape(role),
            style_address=html.escape(place(request, "/login.css")),
            form_address=html.escape(place(request, LOGIN)),
        )
        answer = web.Response(status=status, text=text, content_type="text/html", headers=FORM_HEADERS)
        if status == HTTPStatus.UNAUTHORIZED:
            answer.headers[hdrs.WWW_AUTHENTICATE] = BEARER
        return answer

    async def style(self, _: web.Request) -> web.StreamResponse:
        """Serve the style sheet."""
        return web.Response(text=self._style, content_type="text/css", headers={hdrs.CACHE_CONTROL: "no-cache"})

    async def log_in(self, request: web.Request) -> web.StreamResponse:
        """Look at the form's token; begin a login, or show the form again."""
        if hdrs.ORIGIN not in request.headers:  # one of another site was refused before
            raise web.HTTPForbidden(text="Origin: is missing; log in on this server's page, or send Authorization")
        if not self._admission.asks_for_token:
            return web.Response(status=303, headers={hdrs.LOCATION: place(request, "/")})
        role, token = await _form(request)
        if role is None or not token:
            return self.answer(request, 400, INCOMPLETE)
        try:
            found = self._admission.prove(request, [token], only=role)
        except web.HTTPTooManyRequests as refusal:
            answer = self.answer(request, refusal.status, refusal.text or "", role)
            answer.headers[hdrs.RETRY_AFTER] = refusal.headers[hdrs.RETRY_AFTER]
            return answer
        if found is None:
            return self.answer(request, 401, WRONG, role)
        return self._admission.log_in(request, found)

    async def log_out(self, request: web.Request) -> web.StreamResponse:
        """End the login with all its connections; the drone's control goes back with them."""
        response = self._admission.leave(request)
        request.app[OPEN].end_those_without_access()
        keeper = request.app.get(KEEPER)
        if keeper is not None:
            await keeper.write()
        return response


async def session(request: web.Request) -> web.StreamResponse:
    """Role of the client, the name of a person whose role is for some lots, and whether there is a login to end."""
    access = access_of(request) or Access(Role.VIEWER)
    found = {"role": access.role.value, "login": access.login is not None, "person": access.person}
    return web.json_response(found, headers={hdrs.CACHE_CONTROL: "no-store"})


async def _form(request: web.Request) -> tuple[Role | None, str]:
    """Return role and token of the form; None and an empty text for what is none."""
    if (request.content_length or 0) > LARGEST_FORM_BYTES:
        raise web.HTTPRequestEntityTooLarge(LARGEST_FORM_BYTES, request.content_length or 0)
    body = await request.read()
    try:
        fields = parse_qs(body.decode(), max_num_fields=8)
        role = Role(fields["username"][0].strip().lower())
        return role, fields["password"][0].strip()
    except (ValueError, KeyError):
        return None, ""
