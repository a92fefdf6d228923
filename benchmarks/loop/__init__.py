"""Walks along the advice of the command line: runs what each answer advises, and compares the end with the truth."""
