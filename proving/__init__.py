"""Proofs on the whole product: faults, mutants, fuzzing, a soak, a newcomer's machine."""
