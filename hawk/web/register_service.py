"""The answer to BlueOS, which asks every web server on its computer for a name, an icon and a version.

BlueOS's helper requests ``/`` and then ``/register_service`` from 127.0.0.1, without a token, and adds the answer to
its menu (https://blueos.cloud/docs/latest/development/extensions). Only this computer is answered without a token, so
that the version stays unknown to the network.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Final

from aiohttp import hdrs, web

from hawk.web.access.guesses import is_loopback_peer
from hawk.web.access.proxied import forwarding_header
from hawk.web.services import SERVICES

ADDRESS: Final = "/register_service"


@dataclass(frozen=True, slots=True)
class Registration:
    """Keys as BlueOS's ``ServiceMetadata`` names them (core/services/helper/main.py)."""

    version: str
    name: str = "Hawk"
    description: str = "Parking lot survey: live picture and map of every free and taken stall"
    icon: str = "mdi-quadcopter"
    """A name of Material Design Icons, which BlueOS brings."""
    company: str = "Parking Lot Hawk"
    webpage: str = "https://github.com/parking-lot-hawk/hawk"
    api: str = "/api/schema.json"
    new_page: bool = True
    avoid_iframes: bool = True
    """The page refuses to stand in a frame of another page; BlueOS opens it at its own port."""
    works_in_relative_paths: bool = False
    """The page's addresses begin at the root of its own port, so BlueOS's proxy (/extensionv2/) cannot serve it."""


def add_route(app: web.Application) -> None:
    """Add the route of this module."""
    app.router.add_get(ADDRESS, register)


def is_for_everybody_here(request: web.BaseRequest) -> bool:
    """Return True for this question when a program of this computer asks it: no token is needed then."""
    return request.path == ADDRESS and is_loopback_peer(request.remote) and forwarding_header(request) is None


async def register(request: web.Request) -> web.StreamResponse:
    """Name and version of the product, for BlueOS's menu; nothing of the drone."""
    registration = Registration(request.app[SERVICES].version)
    return web.json_response(asdict(registration), headers={hdrs.CACHE_CONTROL: "no-cache"})
