"""What was computed as the result that a command writes and shows, sentences included: one function per command."""
