"""Exceptions of this room."""

from __future__ import annotations


class ReqFailed(Exception):  # noqa: N818 - the specification's name
    """The autopilot refused a request, or did not answer; the text is its own words where it gave any."""


class TargetRefused(ReqFailed):
    """A target that must not be sent; the text says which condition it fails."""
