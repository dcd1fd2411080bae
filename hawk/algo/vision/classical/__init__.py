"""Finds stalls, cars and lot by painted lines alone: the fallback where no network is wanted."""

from hawk.algo.vision.classical.finder import ClassicalFinder

__all__ = ["ClassicalFinder"]
