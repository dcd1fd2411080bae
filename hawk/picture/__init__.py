"""Pictures of others as surveys: photographs of a drone, films and orthophotos.

    from hawk.picture import map_orthophoto, map_photos

Both are loaded when they are first asked for: the command line starts without them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hawk.picture.city.run import map_orthophoto
    from hawk.picture.photographs.flight import map_photos
    from hawk.picture.values import PictureError, PictureSurvey

__all__ = ["PictureError", "PictureSurvey", "map_orthophoto", "map_photos"]


def __getattr__(name: str) -> Any:
    """Return a function or class of `__all__`. Raises AttributeError for another name."""
    if name == "map_orthophoto":
        from hawk.picture.city.run import map_orthophoto as found
    elif name == "map_photos":
        from hawk.picture.photographs.flight import map_photos as found  # type: ignore[assignment]
    elif name in ("PictureError", "PictureSurvey"):
        from hawk.picture import values

        return getattr(values, name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return found
