"""The C module behind typed arrays."""
