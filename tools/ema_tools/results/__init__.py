"""Results: what every command writes with --json, as types, and the one codec that writes and reads them."""
