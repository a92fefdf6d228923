"""Experiment design: which safe command separates effects that are confounded."""
