"""Canaries in every setting that holds text, searched for in all that is served, written and said."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import re
import tarfile
import tomllib
import typing
from collections.abc import AsyncIterator, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import aiohttp
import pytest
from aiohttp.test_utils import TestServer
from pydantic import BaseModel, SecretStr
from sqlalchemy import Connection, select

from hawk import cli
from hawk.check import actions
from hawk.check.result import failed
from hawk.comm.cameras.drone_camera import DroneCamera
from hawk.comm.clock import Clock
from hawk.comm.protocol.authority import Role
from hawk.config.loader import load_config, variable_of
from hawk.config.reference import reference_text, settings
from hawk.config.secrets import HIDDEN, SecretUrl, is_secret, secrets_of, shown_address, without
from hawk.config.sections import Config, ConfigError
from hawk.daemon.recording_parts import make_recording
from hawk.lots import shares
from hawk.lots.ingest import save
from hawk.lots.storage.schema import SURVEY
from hawk.lots.store import LotStore
from hawk.store.recordings import Recordings
from hawk.store.replay import read_metadata
from hawk.web.access.tokens import TOKEN_FILE, rotate
from hawk.web.app import Page, create_app
from hawk.webhooks.delivery import SenderTimes
from hawk.webhooks.sender import WebhookSender
from proving.api.served import filled
from tests.manual_clock import ManualClock
from tests.pace import PATIENCE_S
from tests.unit.comm.waiting import until
from tests.unit.lots.surveys import BEGAN, survey
from tests.unit.web.rig import Rig

GONE: Final = "127.0.0.1:9"
"""Nobody listens there."""
VALUES: Final[dict[str, Any]] = {
    "autopilot.url": "udpin://canary-autopilot:14550",
    "autopilot.vehicle_address": None,  # an IP address
    "camera.url": f"http://CANARYname:CANARYword@{GONE}/CANARYpath-of-it/x?key=CANARYquery",
    "camera.calibration": "/canary/camera.yaml",
    "flight.outline_file": "/canary/outline.geojson",
    "fence.file": "/canary/fence.geojson",
    "remote_id.operator_id": "canary-operator",
    "remote_id.description": "canary-description",
    "remote_id.serial_number": "canary-serial",
    "vision.model": None,  # the recording names the network that saw: it must be there
    "web.host": "canary-host",
    "web.token": "CANARYtoken-of-the-operator",
    "web.tls_certificate": "/canary/certificate.pem",
    "web.tls_key": "/canary/key.pem",
    "web.allowed_hosts": ["canary-allowed"],
    "web.background_tiles": "/canary/tiles",
    "store.directory": "STORE",
    "store.lots": "/canary/lots.db",
    "webhooks.urls": [f"http://CANARYuser:CANARYpass@{GONE}/CANARYhook/CANARYsegment?CANARYkey"],
    "webhooks.secret": "CANARYsecret-of-the-webhooks",
    "collect.url": f"https://CANARYdesk:CANARYkeyword@{GONE}/CANARYdesk-path",
    "collect.token_file": "/canary/collect-token",
    "collect.certificate": "/canary/desk.pem",
    "inbox.folder": "/canary/inbox",
    "schedule.lot": "canary-lot",
    "schedule.at": None,  # a time
    "schedule.time_zone": None,  # a name of the database
}
"""By setting: a value that is taken. CANARY stands in what is secret, canary in what those who log in may read."""
PROCESSES: Final = re.compile(r"/report\.(pdf|xlsx)$")
"""Answers that a process of its own writes, seconds of a processor each: who has least rights to one asks for it."""
SHARED_PROCESSES: Final = re.compile(rf"/shared/.*{PROCESSES.pattern}")
STREAMS: Final = ("/stream.mjpg", "/video", "/ws")
"""Answers without an end; only their beginning is read."""


def text_settings(model: type[BaseModel] = Config, before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield every setting that can hold text, with its type."""
    for name, field in model.model_fields.items():
        kinds = list(_kinds(field.annotation))
        sections = [each for each in kinds if isinstance(each, type) and issubclass(each, BaseModel)]
        for section in sections:
            yield from text_settings(section, f"{before}{name}.")
        if not sections and any(each in (str, Path) or is_secret(each) for each in kinds):
            yield f"{before}{name}", field.annotation


def _kinds(annotation: Any) -> Iterator[Any]:
    inner = () if typing.get_origin(annotation) is typing.Literal else typing.get_args(annotation)
    yield annotation
    for each in inner:
        yield from _kinds(each)


def given(store: Path) -> dict[str, Any]:
    """Return the settings with canaries, as TOML has them."""
    values: dict[str, Any] = {}
    for name, value in VALUES.items():
        section, key = name.split(".")
        if value is not None:
            values.setdefault(section, {})[key] = str(store) if value == "STORE" else value
    values["schedule"] = [{**values["schedule"], "at": "10:30"}]
    return values


def words_of(data: bytes | str) -> str:
    return data if isinstance(data, str) else data.decode("utf-8", "replace")


def secret_in(data: bytes | str) -> list[str]:
    """Return the secrets that stand in data, in any case: host names are written in small letters."""
    return re.findall(r"CANARY\w+", words_of(data))


def secrets_in_files(folder: Path) -> dict[str, list[str]]:
    """Return the secrets that the files of a folder hold, by their names."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.name: found for path in files if (found := secret_in(path.read_bytes()))}


# -- the settings -----------------------------------------------------------------------------------------------------


def test_every_setting_that_can_hold_text_has_a_canary_and_a_secret_one_a_type() -> None:
    found = dict(text_settings())
    assert set(found) == set(VALUES), (
        "give a new setting a canary, and a type of hawk.config.secrets where it is secret"
    )
    secret = {name for name, value in VALUES.items() if secret_in(json.dumps(value))}
    assert {name for name, kind in found.items() if is_secret(kind)} == secret


def test_whatever_prints_or_dumps_the_settings_shows_no_secret(tmp_path: Path) -> None:
    config = Config.model_validate(given(tmp_path))
    shown = [
        repr(config), str(config), config.model_dump_json(), str(config.model_dump()), f"{config.camera.url}",
        json.dumps(config.model_dump(mode="json")), repr(config.webhooks), f"{config.webhooks.urls}",
        json.dumps([str(each) for each in settings(config, reference_text())]),
    ]  # fmt: skip
    assert [secret_in(each) for each in shown] == [[]] * len(shown)
    assert "canary-operator" in shown[0], "what is none stays"
    held = " ".join(secrets_of(config))
    for secret in secret_in(json.dumps(VALUES)):
        assert secret == "CANARYname" or secret in held, secret
    assert config.camera.url.get_secret_value() == VALUES["camera.url"]


@pytest.mark.parametrize("name", [name for name, value in VALUES.items() if secret_in(json.dumps(value))])
@pytest.mark.parametrize("wrong", ["CANARYnothing", 7, ["CANARYlist"], {"CANARYtable": "CANARYvalue"}, "CANARY://x/ y"])
def test_an_error_does_not_repeat_what_was_given_for_a_secret(name: str, wrong: Any) -> None:
    section, key = name.split(".")
    for values in ({section: {key: wrong}}, {section: wrong}, {section: {key: wrong, "other": wrong}}):
        with pytest.raises(ConfigError) as caught:
            load_config(
                None, {}, typing.cast("Any", values) if isinstance(values[section], dict) else {section: {key: wrong}}
            )
        assert secret_in(str(caught.value)) in ([], ["CANARYtable"]), "a name of a setting is none"
    with contextlib.suppress(ConfigError) as _:
        load_config(None, {variable_of(section, key): "CANARYvariable"})


@pytest.mark.parametrize(
    ("url", "shown"),
    [
        ("http://127.0.0.1:8090", "http://127.0.0.1:8090"),
        ("http://127.0.0.1:8090/", "http://127.0.0.1:8090/"),
        ("rtsp://10.0.0.4/user=a_password=b", "rtsp://10.0.0.4/***"),
        ("rtsp://a:b@c@10.0.0.4:554/x", "rtsp://***@10.0.0.4:554/***"),
        ("rtsp://a:b/c@10.0.0.4", "rtsp://***@10.0.0.4"),
        ("https://host:443/hook/@secret", "https://***@hidden"),
        ("https://[2001:db8::1]:8/x", "https://[2001:db8::1]:8/***"),
        ("gst:rtspsrc location=rtsp://a:b@c user-pw=d ! decodebin ! x y=z", "gst:rtspsrc *** ! decodebin ! x ***"),
        ("v4l2:///dev/video0?width=640&height=480", "v4l2:///dev/video0?width=640&height=480"),
        ("admin:word@camera", "***"),
    ],
)
def test_of_an_address_kind_and_host_are_shown(url: str, shown: str) -> None:
    assert shown_address(url) == str(SecretUrl(url)) == shown


def test_what_a_recording_holds_of_a_camera_is_an_address_still(tmp_path: Path) -> None:
    for url in ("rtsp://a:b@c/d", "https://host:443/hook/@secret", "gst:videotestsrc is-live=true ! videoconvert"):
        masked = Config.model_validate({"camera": {"url": url}}).model_dump(mode="json")
        assert str(Config.model_validate({"camera": masked["camera"]}).camera.url) == shown_address(url)


def test_words_about_an_address_lose_its_secrets() -> None:
    url = SecretUrl("https://example.org/services/T0/abcdefghijkl%20mn?x=12345678")
    said = "404, url='https://example.org/services/T0/abcdefghijkl%20mn?x=12345678', abcdefghijkl mn, 12345678 and 200"
    assert without(said, url.secrets()) == f"404, url='https://example.org/{HIDDEN}', {HIDDEN}, {HIDDEN} and 200"


# -- what is served ---------------------------------------------------------------------------------------------------


@contextlib.asynccontextmanager
async def serving(config: Config, folder: Path) -> AsyncIterator[tuple[TestServer, LotStore, dict[Role, str]]]:
    """Serve a filled store by these settings; the host is that of the test."""
    store = await filled(folder, 2)
    tokens = {role: rotate(folder / TOKEN_FILE, role) for role in Role}
    web = config.web.model_copy(update={"host": "127.0.0.1"})
    rig = Rig(web=web, folder=folder, lots=store, recordings=Recordings(config.store))
    server = TestServer(
        create_app(
            replace(rig.services(), settings=settings(config, reference_text())), Page.load(folder), rig.documentation
        )
    )
    await server.start_server()
    try:
        yield server, store, tokens
    finally:
        await server.close()
        await store.close()


def _ids(connection: Connection) -> dict[str, str]:
    lot, survey = connection.execute(select(SURVEY.c.lot, SURVEY.c.id)).first() or ("", "")
    token = str(shares.share(connection, lot, {"days": 1}, 1.8e9).token)
    numbers = dict.fromkeys(("seq", "row", "column", "zoom", "x", "y"), "1")
    names = {"kind": "geojson", "path": "index.html", "feed": "cds", "collection": "stalls"}
    return {"lot": lot, "id": lot, "survey": survey, "token": token, **names, **numbers}


async def answers(
    server: TestServer, headers: dict[str, str], parts: dict[str, str], but: re.Pattern[str] | None = None
) -> dict[str, str]:
    """Return what each route answers, with its status and headers. ``but``: routes that are not asked."""
    found = {}
    async with aiohttp.ClientSession(headers=headers) as session:
        for route in server.app.router.routes():
            resource = route.resource
            if route.method == "HEAD" or resource is None:
                continue
            canonical = resource.canonical.replace("surveys/{id}", "surveys/{survey}")
            path = re.sub(r"\{(\w+)\}", lambda part: parts.get(part[1], parts["id"]), canonical)
            body = None if route.method in ("GET", "*") else b"{}"
            method = "GET" if route.method == "*" else route.method
            if f"{method} {path}" in found:  # that of every other method, beside the one that was asked
                continue
            if but is not None and but.search(path):
                continue
            async with session.request(
                method,
                server.make_url(path),
                data=body,
                allow_redirects=False,
                timeout=aiohttp.ClientTimeout(PATIENCE_S),
            ) as answer:
                head = f"{answer.status} {dict(answer.headers)}"
                data = b"" if path in STREAMS and answer.status == 200 else await answer.read()
                found[f"{method} {path}"] = head + words_of(data)
    return found


@pytest.mark.slow
async def test_no_route_shows_a_secret_to_any_role_and_strangers_get_no_setting(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    config = Config.model_validate(given(tmp_path))
    async with serving(config, tmp_path) as (server, store, tokens):
        parts = await store.write(_ids)
        said = {"stranger": await answers(server, {}, parts)}
        for role, token in tokens.items():
            but = SHARED_PROCESSES if role is Role.VIEWER else PROCESSES
            said[role.value] = await answers(server, {"Authorization": f"Bearer {token}"}, parts, but)
    for who, each in said.items():
        assert len(each) > 60
        assert {path: secret_in(text) for path, text in each.items() if secret_in(text)} == {}, who
    assert {path for path, text in said["stranger"].items() if "canary" in text} == set()
    for role in Role:  # they were looked at: those who log in read them there, and nowhere else
        assert {path for path, text in said[role.value].items() if "canary" in text} == {"GET /api/settings.json"}
        assert said[role.value]["GET /api/settings.json"].startswith("200")
    assert sum(text.startswith("200") for text in said["operator"].values()) > 45, "most routes were really asked"
    files = [text for each in said.values() for path, text in each.items() if PROCESSES.search(path)]
    assert sorted(text[:3] for text in files) == ["200"] * 6 + ["401"] * 4
    assert secret_in(caplog.text) == []
    assert secrets_in_files(tmp_path) == {}


# -- what is written and said -----------------------------------------------------------------------------------------


async def test_a_recording_holds_no_secret(tmp_path: Path) -> None:
    values = given(tmp_path)
    values["store"]["minimum_free_mb"] = 1
    recording = make_recording(
        Config.model_validate(values), ManualClock(10.0), 1.0, None, lambda: "000001-x", lambda _: None
    )
    recording.begin()
    recording.record("state", {"now": 10.0})
    await recording.close()
    assert recording.path is not None
    kept = read_metadata(recording.path)["configuration"]
    assert secret_in(kept) == secret_in(recording.path.read_bytes()) == []
    assert "canary-operator" in kept


@pytest.mark.slow
def test_the_doctors_bundle_holds_no_secret(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    values = given(tmp_path)
    values["collect"]["token_file"] = str(tmp_path / "collect-token")
    collect = [("collect", name) for name in ("url", "token_file")]
    for section, key in (("web", "token"), ("webhooks", "secret"), ("camera", "url"), *collect):
        monkeypatch.setenv(variable_of(section, key), values[section][key])
    monkeypatch.setenv(variable_of("webhooks", "urls"), values["webhooks"]["urls"][0])
    held = [*secrets_of(Config.model_validate(values)), values["camera"]["url"], *values["webhooks"]["urls"]]
    said = [failed("Camera", f"{each}: no", f"see {each}") for each in held]
    monkeypatch.setattr(actions, "make_checks", lambda _options, _end_s: said)
    out = tmp_path / "bundle.tar.gz"
    assert cli.main(["doctor", "--store", str(tmp_path), "--out", str(out)]) == 0
    with tarfile.open(out) as archive:
        files = [archive.extractfile(member) for member in archive.getmembers()]
        text = "\n".join(words_of(file.read()) for file in files if file is not None)
    assert secret_in(text) == []
    assert GONE in text, "the host of a receiver helps"


@pytest.mark.nightly
async def test_a_camera_and_receivers_that_are_away_are_named_without_secrets(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    config = Config.model_validate({**given(tmp_path), "camera": {"url": VALUES["camera.url"], "reconnect_s": 0.01}})
    camera = DroneCamera(config.camera, Clock())
    said: list[str] = []
    store = LotStore(tmp_path / "lots.db")
    await store.write(lambda connection: save(connection, survey()))
    hooks = config.webhooks.model_copy(update={"allow_private": True})
    sender = WebhookSender(
        store,
        hooks,
        lambda: BEGAN + 1000.0,
        lambda: False,
        lambda *words: said.append(str(words)),
        SenderTimes(0.01, 1.0),
    )
    task = asyncio.create_task(sender.run())
    camera.init()
    try:
        async with asyncio.timeout(10):
            await until(lambda: "Cannot connect" in camera.health.reason)
            await until(lambda: f"webhook {GONE}: try 1" in caplog.text)
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        await camera.close()
        await store.close()
    assert secret_in(caplog.text + camera.health.reason + "".join(said)) == []
    assert secrets_in_files(tmp_path) == {}


def test_a_secret_is_compared_and_no_setting_is_changed_by_its_mask() -> None:
    assert SecretStr("a" * 16) == Config.model_validate({"web": {"token": "a" * 16}}).web.token
    assert tomllib.loads(reference_text())["camera"]["url"] == Config().camera.url.get_secret_value()
