"""Lots that last: their stalls, their surveys, and what each survey saw of each stall."""
