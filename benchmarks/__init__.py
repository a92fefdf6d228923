"""Programs whose figures the documents quote."""
