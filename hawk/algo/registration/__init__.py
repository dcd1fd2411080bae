"""Registration of one map of a lot on another map of it."""
