"""Which fence is in force: the user's polygon, else a circle around the arm place."""

from __future__ import annotations

from hawk.comm.topic import Topic
from hawk.ddc.geofence import Ring, circle, polygon_fence, read_geojson, to_map
from hawk.ddc.settings import DdcSettings
from hawk.model import Fence, GlobalPose


class FenceKeeper:
    """Builds fences from the settings and keeps the one in force.

    The configured polygon or circle is the autopilot's, the outermost; ours lies inside it by the margin. Raises
    FenceError at construction when the file cannot be used.
    """

    def __init__(self, settings: DdcSettings, topic: Topic[Fence]) -> None:
        self._settings = settings
        self._topic = topic
        self._ring: Ring | None = read_geojson(settings.fence.file) if settings.fence.file is not None else None

    @property
    def active(self) -> Fence | None:
        """The fence in force, None before the first arm."""
        return self._topic.value

    def build(self, datum: GlobalPose, latitude: float, longitude: float) -> Fence:
        """Return the fence for a drone that is armed at this place (degrees). Raises FenceError."""
        if self._ring is None:
            outer = circle(to_map(datum, latitude, longitude), self._settings.fence.radius_m)
        else:
            places = (to_map(datum, lat, lon) for lat, lon in self._ring)
            outer = tuple((place.north, place.east) for place in places)
        return polygon_fence(
            outer,
            self._settings.fence.margin_m,
            self._settings.heights.ceiling_m,
            self._settings.fence.ceiling_margin_m,
        )

    def put_in_force(self, fence: Fence) -> None:
        """This fence holds from here on."""
        self._topic.publish(fence)
