"""The extension's labels are what BlueOS's store and its manager of extensions read."""

from __future__ import annotations

import json
import re
import tomllib
from typing import Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from tests.unit.packaging.containerfile import ROOT, read
from tests.unit.packaging.scripts import load

build_container = load("container/build_container")
STAGES = {stage.name: stage for stage in read()[1]}
LABELS = STAGES["blueos"].labels()
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
PAGE = (ROOT / "docs" / "blueos.md").read_text("utf-8")


class Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class Author(Strict):
    """blueos_repository/extension/models.py of BlueOS-Extensions-Repository, as the classes below."""

    name: str
    email: str


class Company(Strict):
    name: str
    about: str | None = None
    email: str | None = None


class Links(BaseModel):
    """Further keys are further links. `docs` and `documentation` are read as JSON5 there, so an address breaks them."""

    model_config = ConfigDict(extra="allow")

    website: str = Field(pattern=r"^https://")
    support: str = Field(pattern=r"^(https://|mailto:)")
    docs: None = None
    documentation: None = None


class Limit(Strict):
    Name: str
    Soft: int
    Hard: int


class RestartPolicy(Strict):
    Name: Literal["unless-stopped", "always"]


class HostConfig(Strict):
    """Keys of Docker's API (POST /containers/create) that the extension may use: none that gives it more."""

    NetworkMode: Literal["host"]
    RestartPolicy: RestartPolicy
    Binds: list[str]
    CapDrop: list[str]
    SecurityOpt: list[str]
    OomScoreAdj: int = Field(ge=-1000, le=1000)
    Ulimits: list[Limit]


class Permissions(Strict):
    """The body of Docker's POST /containers/create, as BlueOS's kraken hands it on."""

    HostConfig: HostConfig
    Env: list[str] = []


def test_the_label_of_the_version_is_the_projects() -> None:
    assert LABELS["version"] == "${VERSION}"
    assert STAGES["blueos"].all("ARG") == ["VERSION"]
    assert re.fullmatch(r"\d+\.\d+\.\d+", PROJECT["version"]), "BlueOS's store takes semantic versions only"


def test_the_image_has_what_a_camera_by_rtsp_needs() -> None:
    source = (ROOT / "hawk" / "comm" / "cameras" / "sources" / "rtsp.py").read_text("utf-8")
    installed = " ".join(STAGES["blueos"].all("RUN")).split()
    assert set(re.findall(r"gstreamer1\.0-[a-z]+(?:-[a-z]+)?", source)) <= set(installed)


def test_people_and_links_are_as_the_store_reads_them() -> None:
    authors = TypeAdapter(list[Author]).validate_json(LABELS["authors"])
    assert authors
    assert Company.model_validate_json(LABELS["company"]).name == "Parking Lot Hawk"
    links = Links.model_validate_json(LABELS["links"])
    assert links.website == PROJECT["urls"]["Homepage"]
    assert links.support == PROJECT["urls"]["Issues"]
    control = (ROOT / "debian" / "control").read_text("utf-8")
    assert f"Maintainer: {authors[0].name} <{authors[0].email}>" in control


def test_type_tags_and_requirements_are_as_the_store_reads_them() -> None:
    assert LABELS["type"] in {"device-integration", "example", "theme", "other", "tool"}
    tags = json.loads(LABELS["tags"])
    assert 0 < len(tags) <= 10
    assert all(re.fullmatch(r"[a-z0-9-]+", tag) for tag in tags)
    assert re.fullmatch(r"core >= \d+\.\d+", LABELS["requirements"])


def test_the_readme_is_a_page_of_this_repository() -> None:
    found = re.fullmatch(r"https://raw\.githubusercontent\.com/([\w-]+/\w+)/v\{tag\}/(.+)", LABELS["readme"])
    assert found is not None
    assert PROJECT["urls"]["Homepage"].endswith(found[1])
    assert (ROOT / found[2]).is_file()


def test_the_permissions_give_a_network_and_two_volumes_and_nothing_else() -> None:
    host = Permissions.model_validate_json(LABELS["permissions"]).HostConfig
    assert host.CapDrop == ["ALL"]
    assert host.SecurityOpt == ["no-new-privileges"]
    volumes = json.loads(STAGES["program"].all("VOLUME")[0])
    assert [bind.split(":")[1] for bind in host.Binds] == volumes
    # a folder of the host would be made by root, and the image's user could not write there
    assert all(re.fullmatch(r"hawk-[a-z]+:/[a-z/]+:rw", bind) for bind in host.Binds)
    unit = (ROOT / "packaging" / "systemd" / "hawk-drone.service").read_text("utf-8")
    limits = {limit.Name: limit.Hard for limit in host.Ulimits}
    niceness = int(re.search(r"^Nice=(.*)$", unit, re.MULTILINE)[1])  # type: ignore[index]
    assert limits["nice"] == 20 - niceness  # setrlimit(2)
    assert f"LimitNOFILE={limits['nofile']}" in unit
    assert f"OOMScoreAdjust={host.OomScoreAdj}" in unit


@pytest.mark.parametrize("key", ["Privileged", "CapAdd", "Devices", "PidMode"])
def test_the_model_refuses_what_would_give_more(key: str) -> None:
    permissions = json.loads(LABELS["permissions"])
    permissions["HostConfig"][key] = True
    with pytest.raises(ValidationError, match=key):
        Permissions.model_validate_json(json.dumps(permissions))


def test_the_page_names_the_settings_of_the_image() -> None:
    for name, _, value in build_container.SETTINGS["blueos"]:
        assert f"| `{name}` |" in PAGE
        for word in re.findall(r'"([^"]+)"', value) or [value]:
            assert f"`{word}`" in PAGE, word
    for bind in json.loads(LABELS["permissions"])["HostConfig"]["Binds"]:
        assert f"`{bind.split(':')[0]}`" in PAGE or f"{bind.rpartition(':')[0]} " in PAGE


def test_the_settings_json_of_the_page_is_valid() -> None:
    (line,) = re.findall(r'^    ("Env": .*)$', PAGE, re.MULTILINE)
    (device,) = re.findall(r'`("Devices": .*?\])`', re.sub(r"\n\s+", " ", PAGE))
    assert json.loads("{" + line + "}")["Env"][0].startswith("HAWK_CAMERA__URL=")
    assert set(json.loads("{" + device + "}")["Devices"][0]) == {"PathOnHost", "PathInContainer", "CgroupPermissions"}
