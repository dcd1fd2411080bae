"""Exceptions of the algorithm modules, named as in the specification."""

from __future__ import annotations

from hawk.comm.image import NoImage

__all__ = ["AlgoError", "NoImage"]


class AlgoError(Exception):
    """An algorithm could not do its work on this frame; the text says why (specification sections 10 to 13)."""
