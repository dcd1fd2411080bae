"""The shortest path inside our fence, and the sight of a place past its corners. Map frame, metres.

A shortest path in a polygon turns only at corners that point inwards, those of holes included, and is taut there. The
graph of the corners that see each other is made once for each fence, in 10 to 80 ms for 70 corners; a path then costs
1 to 3 ms (one core of a 2-core x86-64 server).
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.polygon import orient

from hawk.ddc.fence.geometry import contains, path_is_inside, shape
from hawk.model.plans import Fence, Route
from hawk.model.poses import MapPoint

ROOM_M = (2.0, 1.0, 0.5, 0.0)
"""Room that a path keeps from our limit, metres: the first of these with which there is a path."""
SIGHT_ROOM_M = 1.0
"""A place is in sight when the straight line to it passes each corner by this distance, metres."""
CUTS_M = (8.0, 4.0, 2.5)
"""A corner may be cut this many metres before and behind it; one that the least of these does not fit is a stop."""
_FLAT = 1e-9  # sine of a turn that is none: a corner too many costs little, one too few would lose a path

Places = NDArray[np.float64]
"""(N, 2) of (north, east), metres."""


def path_inside(fence: Fence, start: MapPoint, end: MapPoint) -> tuple[MapPoint, ...] | None:
    """Return the shortest path inside our fence, from start to end; None when an end is outside or nothing joins them.

    The straight line is the path where it is inside. A path round corners keeps `ROOM_M` from our limit, less where the
    ground is too narrow. An end nearer to the limit than that is joined to it by a straight leg inside the fence.
    """
    if not (contains(fence, start) and contains(fence, end)):
        return None
    if path_is_inside(fence, start, end):
        return (start, end)
    for room in ROOM_M:
        found = _shortest(fence, room, (start.north, start.east), (end.north, end.east))
        if found is not None:
            return (start, *(MapPoint(north, east) for north, east in found), end)
    return None


def route_inside(fence: Fence, start: MapPoint, end: MapPoint) -> Route | None:
    """Return `path_inside` as a route; its corners may be cut where that leaves `SIGHT_ROOM_M` to our limit."""
    path = path_inside(fence, start, end)
    if path is None:
        return None
    return Route(path, _cuts(fence, path))


def length(path: tuple[MapPoint, ...]) -> float:
    """Return the length of a path, metres."""
    return sum(a.distance(b) for a, b in pairwise(path))


def is_in_sight(fence: Fence, place: MapPoint, aim: MapPoint) -> bool:
    """Return True when the straight line is inside our fence and passes its corners with `SIGHT_ROOM_M` to spare.

    A corner nearer than that to one end must not be passed nearer still.
    """
    if not path_is_inside(fence, place, aim):
        return False
    corners = _ground(fence, 0.0).corners
    if place == aim or not len(corners):
        return True
    line = shapely.linestrings([(place.north, place.east), (aim.north, aim.east)])
    points = shapely.points(corners)
    ends = shapely.points([(place.north, place.east), (aim.north, aim.east)])
    nearest = np.minimum(shapely.distance(points, ends[0]), shapely.distance(points, ends[1]))
    return bool(np.all(shapely.distance(points, line) >= np.minimum(nearest, SIGHT_ROOM_M) - 1e-6))


@dataclass(frozen=True, slots=True)
class _Ground:
    """Ground that keeps some room from our limit; it may be empty, or several pieces.

    ``corners``: those that point inwards, with the corners ``before`` and ``behind`` each on its ring.
    """

    shape: shapely.Geometry
    corners: Places
    before: Places
    behind: Places


def prepare(fence: Fence) -> None:
    """Make what the paths of a fence need, up to a tenth of a second: for a thread of its own."""
    for room in ROOM_M:
        _neighbours(fence, room)


@lru_cache(maxsize=12)
def _ground(fence: Fence, room: float) -> _Ground:
    whole = shape(fence)
    if room > 0.0:
        whole = shapely.buffer(whole, -room, join_style="mitre", mitre_limit=5.0)
        shapely.prepare(whole)
    return _Ground(whole, *_inward_corners(whole))


@lru_cache(maxsize=12)
def _neighbours(fence: Fence, room: float) -> tuple[tuple[tuple[int, float], ...], ...]:
    """Return for each inward corner those that a taut path may go on to: index and metres."""
    ground = _ground(fence, room)
    corners, before, behind = ground.corners, ground.before, ground.behind
    one, other = np.triu_indices(len(corners), 1)
    taut = _is_taut(corners[one], corners[other], before[other], behind[other]) & _is_taut(
        corners[other], corners[one], before[one], behind[one]
    )
    one, other = one[taut], other[taut]
    seen = _sees(ground.shape, corners[one], corners[other])
    found: list[list[tuple[int, float]]] = [[] for _ in corners]
    for a, b in zip(one[seen].tolist(), other[seen].tolist(), strict=True):
        metres = math.dist(corners[a], corners[b])
        found[a].append((b, metres))
        found[b].append((a, metres))
    return tuple(map(tuple, found))


def _inward_corners(ground: shapely.Geometry) -> tuple[Places, Places, Places]:
    """Return the corners at which a path may turn, with the corners before and behind each on its ring."""
    found: list[Places] = []
    for piece in shapely.get_parts(ground):
        if piece.is_empty:
            continue
        whole = orient(piece)  # inside is on the left of each ring
        for ring in (whole.exterior, *whole.interiors):
            at = np.asarray(ring.coords)[:-1, :2]
            before, behind = np.roll(at, 1, axis=0), np.roll(at, -1, axis=0)
            into, out = at - before, behind - at
            turn = _cross(into, out)
            scale = np.linalg.norm(into, axis=1) * np.linalg.norm(out, axis=1)
            found.append(np.stack([at, before, behind], axis=1)[turn <= _FLAT * scale])
    corners = np.concatenate(found) if found else np.empty((0, 3, 2))
    return corners[:, 0], corners[:, 1], corners[:, 2]


def _cross(one: Places, other: Places) -> NDArray[np.float64]:
    product: NDArray[np.float64] = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return product


def _is_taut(origin: Places, corner: Places, before: Places, behind: Places) -> NDArray[np.bool_]:
    """Return True where a line from the origin touches the corner without going through it: a string may bend there."""
    line, back, on = corner - origin, before - corner, behind - corner
    slack = _FLAT * np.linalg.norm(line, axis=-1)
    one, other = _cross(line, back), _cross(line, on)
    loose, free = slack * np.linalg.norm(back, axis=-1), slack * np.linalg.norm(on, axis=-1)
    taut: NDArray[np.bool_] = ((one >= -loose) & (other >= -free)) | ((one <= loose) & (other <= free))
    return taut


def _sees(ground: shapely.Geometry, one: Places, other: Places) -> NDArray[np.bool_]:
    """Return for each pair whether the straight line between them is on the ground."""
    if not len(one):
        return np.zeros(0, dtype=bool)
    seen: NDArray[np.bool_] = shapely.covers(ground, shapely.linestrings(np.stack([one, other], axis=1)))
    return seen


def _shortest(
    fence: Fence, room: float, start: tuple[float, float], end: tuple[float, float]
) -> list[tuple[float, float]] | None:
    """Return the corners of the shortest path by Dijkstra's algorithm; None when there is none with this room."""
    ground, neighbours = _ground(fence, room), _neighbours(fence, room)
    first, last = _joined(fence, ground, start), _joined(fence, ground, end)
    best = dict(first)
    came: dict[int, int] = {}
    queue = [(metres, corner) for corner, metres in first.items()]
    heapq.heapify(queue)
    goal, at_goal = math.inf, -1
    while queue:
        metres, corner = heapq.heappop(queue)
        if metres >= goal:
            break
        if metres > best[corner]:
            continue
        if corner in last and metres + last[corner] < goal:
            goal, at_goal = metres + last[corner], corner
        for further, leg in neighbours[corner]:
            if metres + leg < best.get(further, math.inf):
                best[further] = metres + leg
                came[further] = corner
                heapq.heappush(queue, (metres + leg, further))
    if at_goal < 0:
        return None
    path = [at_goal]
    while path[-1] in came:
        path.append(came[path[-1]])
    return [(float(ground.corners[k][0]), float(ground.corners[k][1])) for k in reversed(path)]


def _joined(fence: Fence, ground: _Ground, place: tuple[float, float]) -> dict[int, float]:
    """Return the corners that a path from this place may go to first, with their metres."""
    origin = np.broadcast_to(np.array(place), ground.corners.shape)
    if shapely.intersects_xy(ground.shape, *place):
        index = np.flatnonzero(_is_taut(origin, ground.corners, ground.before, ground.behind))
        over = ground.shape
    else:
        index, over = np.arange(len(origin)), shape(fence)
    seen = index[_sees(over, origin[index], ground.corners[index])]
    return {int(k): math.dist(place, ground.corners[k]) for k in seen}


def _cuts(fence: Fence, path: tuple[MapPoint, ...]) -> tuple[float, ...]:
    """Return for each point the metres before and behind it within which its corner may be cut; 0: a stop."""
    if len(path) < 3:
        return (0.0,) * len(path)
    at = np.array([(point.north, point.east) for point in path])
    back, on = at[:-2] - at[1:-1], at[2:] - at[1:-1]
    lengths = np.stack([np.linalg.norm(back, axis=1), np.linalg.norm(on, axis=1)])
    cuts = np.array(CUTS_M)[:, None]
    ends = [at[1:-1] + leg * (cuts / long)[..., None] for leg, long in zip((back, on), lengths, strict=True)]
    corners = np.broadcast_to(at[1:-1], ends[0].shape)
    triangles = shapely.polygons(np.stack([ends[0], corners, ends[1]], axis=2))
    free = shapely.covers(_ground(fence, SIGHT_ROOM_M).shape, triangles) & (cuts <= lengths.min(axis=0) / 2)
    return (0.0, *(float(CUTS_M[np.argmax(row)]) if row.any() else 0.0 for row in free.T), 0.0)
