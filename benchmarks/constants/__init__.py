"""The numbers that steer the diagnosis: where each stands, what set it, and what its answers owe to it."""
