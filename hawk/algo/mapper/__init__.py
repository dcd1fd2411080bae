"""Mapper App: fuses all frames into one map."""
