"""The token file and the command that writes it."""

from __future__ import annotations

import json
import stat
from pathlib import Path

import pytest
from pydantic import SecretStr

from hawk.cli import EXIT_USAGE, main
from hawk.comm.protocol.authority import Role
from hawk.config.loader import load_config
from hawk.config.sections import ConfigError, WebSettings
from hawk.web.access.tokens import TOKEN_FILE, Tokens, TokensError, cookie_secret, read_tokens, rotate, with_configured
from hawk.web.security import InsecureBindingError, check_binding

CONFIGURED = "correct-horse-battery"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / TOKEN_FILE


def test_a_token_is_random_and_kept_as_a_hash_in_a_private_file(path: Path) -> None:
    token = rotate(path, Role.OPERATOR)
    assert len(token) == 22, "128 bits"
    assert token not in path.read_text()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert read_tokens(path).role_of(token) is Role.OPERATOR
    assert rotate(path, Role.OPERATOR) != token
    assert read_tokens(path).role_of(token) is None


def test_a_new_token_of_one_role_leaves_the_other(path: Path) -> None:
    operator, viewer = rotate(path, Role.OPERATOR), rotate(path, Role.VIEWER)
    rotate(path, Role.VIEWER)
    tokens = read_tokens(path)
    assert tokens.role_of(operator) is Role.OPERATOR
    assert tokens.role_of(viewer) is None


def test_the_same_token_has_another_hash_each_time(path: Path) -> None:
    rotate(path, Role.OPERATOR)
    rotate(path, Role.VIEWER)
    kept = json.loads(path.read_text())["tokens"].values()
    assert len({each["salt"] for each in kept}) == 2


def test_without_a_file_there_are_no_tokens(path: Path) -> None:
    assert not read_tokens(path)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        '{"tokens": []}',
        '{"tokens": {"admin": {"salt": "00", "sha256": "00"}}}',
        '{"tokens": {"operator": {"salt": "00", "sha256": "00"}}}',
        '{"tokens": {"operator": {"salt": "xy", "sha256": "00"}}}',
        '{"tokens": {"operator": {}}}',
        '{"tokens": {"operator": 7}}',
        "[" * 20_000,
        " " * 70_000,
    ],
)
def test_a_damaged_file_is_named_with_the_remedy(path: Path, text: str) -> None:
    path.write_text(text)
    path.chmod(0o600)
    with pytest.raises(TokensError, match=r"is damaged .*hawk-drone tokens rotate operator"):
        read_tokens(path)
    with pytest.raises(TokensError):
        rotate(path, Role.OPERATOR)
    assert path.read_text() == text, "nothing is lost by a command that fails"


@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_file_that_others_may_write_is_refused(path: Path, mode: int) -> None:
    rotate(path, Role.OPERATOR)
    path.chmod(mode)
    with pytest.raises(TokensError, match="chmod 600"):
        read_tokens(path)


def test_a_file_that_cannot_be_read_is_named(path: Path) -> None:
    path.mkdir()
    with pytest.raises(TokensError, match="cannot be read"):
        read_tokens(path)


# -- web.token --------------------------------------------------------------------------------------------------------


def test_the_configured_token_is_the_operators(path: Path) -> None:
    rotate(path, Role.VIEWER)
    tokens = with_configured(read_tokens(path), SecretStr(CONFIGURED), b"secret")
    assert tokens.role_of(CONFIGURED) is Role.OPERATOR
    assert tokens.proof(Role.OPERATOR) == with_configured(Tokens(), SecretStr(CONFIGURED), b"secret").proof(
        Role.OPERATOR
    )
    assert tokens.proof(Role.OPERATOR) != with_configured(Tokens(), SecretStr(CONFIGURED + "x"), b"secret").proof(
        Role.OPERATOR
    )


def test_an_operators_token_of_the_file_ends_the_configured_one(path: Path, caplog: pytest.LogCaptureFixture) -> None:
    token = rotate(path, Role.OPERATOR)
    tokens = with_configured(read_tokens(path), SecretStr(CONFIGURED), b"secret")
    assert tokens.role_of(CONFIGURED) is None
    assert tokens.role_of(token) is Role.OPERATOR
    assert "web.token is not in use" in caplog.text


def test_a_viewers_token_alone_is_refused_also_on_loopback(path: Path) -> None:
    rotate(path, Role.VIEWER)
    with pytest.raises(InsecureBindingError, match="has no operator's token"):
        check_binding(WebSettings(), read_tokens(path), path.parent)


def test_the_refusal_off_loopback_names_the_command_that_makes_a_token(tmp_path: Path) -> None:
    with pytest.raises(InsecureBindingError, match=f"hawk-drone tokens rotate operator --store {tmp_path}"):
        check_binding(WebSettings(host="0.0.0.0"), Tokens(), tmp_path)


def test_the_configured_token_is_not_repeated_by_an_error_of_its_section() -> None:
    values = {"web": {"token": CONFIGURED, "tls_key": "key.pem"}}
    with pytest.raises(ConfigError, match="tls_certificate is missing") as error:
        load_config(None, {}, values)
    assert CONFIGURED not in str(error.value)


def test_the_idle_limit_is_not_above_the_other() -> None:
    with pytest.raises(ValueError, match="session_idle_h must not be more"):
        WebSettings(session_idle_h=48, session_limit_h=24)


# -- the command ------------------------------------------------------------------------------------------------------


def test_the_command_prints_the_token_alone_on_standard_output(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["tokens", "rotate", "operator", "--store", str(tmp_path / "store")]) == 0
    said = capsys.readouterr()
    token = said.out.strip()
    assert read_tokens(tmp_path / "store" / TOKEN_FILE).role_of(token) is Role.OPERATOR
    assert f"http://127.0.0.1:3000/?token={token}" in said.err


def test_a_viewer_comes_after_an_operator(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["tokens", "rotate", "viewer", "--store", str(tmp_path)]
    assert main(command) == EXIT_USAGE
    assert f"tokens rotate operator --store {tmp_path}" in capsys.readouterr().err
    assert not (tmp_path / TOKEN_FILE).exists()
    monkeypatch.setenv("HAWK_WEB__TOKEN", CONFIGURED)
    assert main(command) == 0


def test_the_command_names_a_file_that_it_cannot_use(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / TOKEN_FILE).write_text("{")
    assert main(["tokens", "rotate", "operator", "--store", str(tmp_path)]) == EXIT_USAGE
    assert "is damaged" in capsys.readouterr().err
    (tmp_path / "file").write_text("")
    assert main(["tokens", "rotate", "operator", "--store", str(tmp_path / "file")]) == EXIT_USAGE
    assert "cannot be read" in capsys.readouterr().err


def test_the_secret_is_kept_for_the_next_start(tmp_path: Path) -> None:
    made = cookie_secret(tmp_path)
    assert len(made) == 32
    assert cookie_secret(tmp_path) == made
    (path,) = tmp_path.iterdir()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    path.write_bytes(b"cut off")
    assert len(cookie_secret(tmp_path)) == 32


def test_a_secret_that_cannot_be_kept_is_reported(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert len(cookie_secret(tmp_path / "absent")) == 32
    assert "after a restart" in caplog.text
