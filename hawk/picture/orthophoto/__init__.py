"""Orthophotos as surveys: opened with their place on Earth, mapped window by window, the windows merged."""
