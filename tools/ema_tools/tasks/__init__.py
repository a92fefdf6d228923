"""One module per command: inputs in, one result out."""
