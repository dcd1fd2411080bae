from __future__ import annotations

import json
import os
import tarfile
from collections.abc import Sequence
from pathlib import Path

import pytest

from hawk import cli
from hawk.check import actions, doctor
from hawk.check.doctor import SecretFilter, collect, run_command, write_bundle
from hawk.check.result import CheckResult, failed
from hawk.comm.protocol.authority import Role
from hawk.config.secrets import secrets_of
from hawk.config.sections import Config
from hawk.daemon.announcement import ADDRESS_FILE
from hawk.store.journal_state import pack
from hawk.web.access.tls import CertificatePlan, make_certificate
from hawk.web.access.tokens import TOKEN_FILE, cookie_secret, rotate

WEB_TOKEN = "settings-token-Zk3vQ9"
CAMERA_PASSWORD = "camera/pass-Wm71"
QUERY = "query-value-Hh20x"
PIPELINE_PASSWORD = "pipePw-Tt55"
FOREIGN_TOKEN = "Qq8Yx-77_foreignTokenOfAnotherProgram"


def furnish(folder: Path) -> list[str]:
    """Write a store with every kind of secret; return those secrets."""
    token = rotate(folder / TOKEN_FILE, Role.OPERATOR)
    secret = cookie_secret(folder)
    made = make_certificate(CertificatePlan(folder, ("localhost",), 30))
    (folder / ADDRESS_FILE).write_text(f"http://drone:3000/?token={token}\n")
    (folder / "web-logins.json").write_text('{"logins": ["login-Gg31-xyzw"]}')
    (folder / "notes.txt").write_text("notes-Pp42-of-mine")
    (folder / "recordings").mkdir()
    (folder / "recordings" / "flight.mcap").write_bytes(b"recording-Rr64-data" * 100)
    (folder / "params.json").write_text(json.dumps({"desired_m": 35, "note": f"token={FOREIGN_TOKEN}"}))
    journal = folder / "journal" / "000001-first"
    journal.mkdir(parents=True)
    records = [
        ("datum", b'{"latitude": 43.5}'),
        ("map/tile", b"map-Mm20"),
        ("start/1", b"token abcdefghijklmnopqrstuvwx"),
    ]
    (journal / "000000.journal").write_bytes(b"".join(pack(*each) for each in records))
    hashes = [each["sha256"] for each in json.loads((folder / TOKEN_FILE).read_text())["tokens"].values()]
    key = made.key.read_text().splitlines()
    certificate = made.certificate.read_text().splitlines()
    return [
        token, secret.hex(), secret.decode("latin-1"), *hashes, *key[1:-1], *certificate[1:-1], "login-Gg31",
        "notes-Pp42", "recording-Rr64", "map-Mm20", FOREIGN_TOKEN, "abcdefghijklmnopqrstuvwx",
    ]  # fmt: skip


def words_of(path: Path) -> str:
    """Return everything that a bundle holds: names and contents."""
    with tarfile.open(path) as archive:
        found = [member.name for member in archive]
        files = [archive.extractfile(member) for member in archive.getmembers()]
        found += [file.read().decode() for file in files if file is not None]
        assert None not in files
    return "\n".join(found)


def write_settings(tmp_path: Path, camera: str) -> Path:
    file = tmp_path / "config.toml"
    file.write_text(
        f'[web]\ntoken = "{WEB_TOKEN}"\n[camera]\nurl = """{camera}"""\n[store]\ndirectory = "{tmp_path}/store"\n'
    )
    return file


@pytest.mark.slow
@pytest.mark.parametrize(
    "camera",
    [
        f"rtsp://admin:{CAMERA_PASSWORD}@10.0.0.2/live?auth={QUERY}",
        f"gst:rtspsrc location=rtsp://10.0.0.2/ user-id=admin user-pw={PIPELINE_PASSWORD} ! decodebin",
    ],
)
def test_no_secret_of_any_place_is_in_the_bundle(
    tmp_path: Path, camera: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    store = tmp_path / "store"
    store.mkdir()
    secrets = furnish(store)
    said = [
        f"hawk: open http://drone:3000/?token={secrets[0]}",
        f"GET /video?token={secrets[0]}&plain=1",
        f"the token of the role operator is {secrets[0]} and then {FOREIGN_TOKEN}",
        f'{{"token": "{FOREIGN_TOKEN}", "password": "{CAMERA_PASSWORD}"}}',
        f"Authorization: Bearer {FOREIGN_TOKEN}",
        f"Cookie: hawk={secrets[0]}",
        f"camera: rtsp://admin:{CAMERA_PASSWORD}@10.0.0.2/live failed",
        f"web.token {WEB_TOKEN} is short",
        f"pipeline user-pw={PIPELINE_PASSWORD}",
        "ordinary line that stays",
    ]
    monkeypatch.setattr(doctor, "run_command", lambda _command: "\n".join(said))
    monkeypatch.setattr(collect, "__defaults__", (doctor.run_command,))
    results = [failed("Camera", f"rtsp://admin:{CAMERA_PASSWORD}@10.0.0.2/live: no", f"see ?auth={QUERY}")]
    monkeypatch.setattr(actions, "make_checks", lambda _options, _end_s: results)
    out = tmp_path / "bundle.tar.gz"
    assert cli.main(["doctor", "--config", str(write_settings(tmp_path, camera)), "--out", str(out)]) == 0
    words = words_of(out)
    everywhere = [WEB_TOKEN, *secrets]
    everywhere += [CAMERA_PASSWORD, QUERY] if "auth=" in camera else [PIPELINE_PASSWORD]
    for secret in everywhere:
        assert secret not in words, secret
    assert CAMERA_PASSWORD not in words
    files = ("last-flight.txt", "web-tokens.json", "flight.mcap")
    for kept in (*files, "ordinary line that stays", "page-secret", "desired_m", "43.5"):
        assert kept in words
    assert out.stat().st_mode & 0o077 == 0
    shown = capsys.readouterr().out
    assert str(out) in shown
    assert "Look through it before you send it" in shown
    assert "settings.json" in shown


@pytest.mark.slow
def test_settings_that_cannot_be_read_still_give_a_bundle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = tmp_path / "config.toml"
    config.write_text(f'[web]\ntoken = "{WEB_TOKEN}"\nport = 99999999\n')
    results = [failed("Configuration", "web.port: must lie between 0 and 65535", "Correct it.")]
    monkeypatch.setattr(actions, "make_checks", lambda _options, _end_s: results)
    out = tmp_path / "bundle.tar.gz"
    assert cli.main(["doctor", "--config", str(config), "--store", str(tmp_path), "--out", str(out)]) == 0
    words = words_of(out)
    assert "must lie between" in words
    assert "settings.json" not in words
    assert WEB_TOKEN not in words


def test_links_are_not_followed(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").write_text("elsewhere-Ee11")
    store = tmp_path / "store"
    (store / "journal" / "000001-a").mkdir(parents=True)
    for name in ("params.json", "fence.geojson", "journal/000001-a/000000.journal"):
        (store / name).symlink_to(tmp_path / "elsewhere")
    parts = collect(None, store, [], SecretFilter(), lambda _: "")
    assert "elsewhere-Ee11" not in "".join(parts.values())


def test_an_existing_file_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "mine.tar.gz"
    out.write_text("mine")
    assert cli.main(["doctor", "--out", str(out)]) == 2
    assert cli.main(["doctor", "--out", str(tmp_path / "mine.zip")]) == 2
    assert "--out" in capsys.readouterr().err
    assert cli.main(["doctor", "--out", f"{'n' * 300}.tar.gz"]) == 2
    assert "cannot be written: File name too long; name a folder" in capsys.readouterr().err
    with pytest.raises(FileExistsError):
        write_bundle(out, {}, 0.0)
    assert out.read_text() == "mine"


@pytest.mark.slow
def test_the_journal_of_a_survey_is_read_and_not_changed(tmp_path: Path) -> None:
    furnish(tmp_path)
    segment = tmp_path / "journal" / "000001-first" / "000000.journal"
    segment.write_bytes(segment.read_bytes() + b"torn")
    before = segment.read_bytes(), segment.stat().st_mtime_ns, os.listdir(segment.parent)
    asked: list[Sequence[str]] = []
    checks: list[CheckResult] = []

    def run(command: Sequence[str]) -> str:
        asked.append(command)
        return ""

    parts = collect(Config(), tmp_path, checks, SecretFilter(secrets_of(Config())), run)
    kept = json.loads(parts["flight-journal.json"])["000001-first"]
    assert kept["values"]["datum"] == '{"latitude": 43.5}'
    assert (kept["map_parts"], kept["lost_bytes"]) == (1, 4)
    assert (segment.read_bytes(), segment.stat().st_mtime_ns, os.listdir(segment.parent)) == before
    assert asked[0][:3] == ["journalctl", "-u", "hawk-drone"]
    assert "daemon-journal.txt" not in parts
    versions = json.loads(parts["version.json"])
    assert "hawk-drone" in versions
    assert "numpy" in versions["packages"]
    assert json.loads(parts["machine.json"])["memory_bytes"] > 0


def test_a_command_that_is_not_there_says_nothing() -> None:
    assert run_command(["no-such-command-here"]) == ""
    assert run_command(["echo", "a word"]) == "a word\n"


@pytest.mark.parametrize(
    "text",
    [
        "Tokens: hawk-drone tokens rotate operator makes another",
        "http://127.0.0.1:3000/ is open",
        "ordinary-long-word-of-many-characters stays",
        "udpin://127.0.0.1:14550",
    ],
)
def test_ordinary_words_stay(text: str) -> None:
    assert SecretFilter(["", "abc"]).clean(text) == text
