"""Lots that last: the same stall in later surveys of the same lot."""
