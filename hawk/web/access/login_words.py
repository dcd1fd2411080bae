"""The words of the login page in the languages that it speaks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

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
    role_note="operator flies, viewer watches",
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
    role_note="operator pilote, viewer regarde",
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
