"""Mutants: small faults put into the modules that decide about safety, to see whether their tests notice."""
