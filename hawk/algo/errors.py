"""Exceptions of the algorithm modules, named as in the specification."""

from __future__ import annotations


class AlgoError(Exception):
    """An algorithm could not do its work on this frame; the text says why (specification sections 10 to 13)."""


class NoImage(Exception):  # noqa: N818 - the specification's name
    """There is no picture that can be decoded in this frame (specification section 10)."""
