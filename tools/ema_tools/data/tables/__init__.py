"""Files of any maker as recordings: `read` looks at a file, `table_map` says which column is what, `convert` makes records of both."""
