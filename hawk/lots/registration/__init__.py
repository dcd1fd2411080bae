"""Places of surveys: on Earth, in a lot, and among its stalls."""
