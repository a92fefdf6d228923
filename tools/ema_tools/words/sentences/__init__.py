"""Sentences, from what was computed: each is made once, for terminal, page and JSON."""
