"""What every result holds beside its own numbers: curves, and where it came from."""
