"""How often the verdict of `ema identify` is right, on units that the code under test has never seen, and a search for answers that are surely wrong."""
