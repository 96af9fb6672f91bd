"""Structure-aware fuzzing of all readers: `python -m tests.fuzz TARGET --seconds N`."""
