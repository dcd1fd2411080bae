"""Differences between surveys and a layout, proposed to persons, and their adoption."""
