def written(rows, command, folder):
    return "## Ranks"
