"""Equations of one group of blocks, each from measured signals alone."""
