"""Machines whose controller nobody knows: which effect the balance of forces names on records of their motion and drive alone."""
