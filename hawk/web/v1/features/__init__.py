"""OGC API Features: parameters, answers and reads."""
