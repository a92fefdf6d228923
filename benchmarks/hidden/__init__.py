"""Hidden effects on machines that the code under test has never seen: how often it names the right one. `python -m benchmarks.hidden`.

`machines` simulates, `catalogue` says what is hidden and how large, `trials` lists and runs the trials, `sealed` is the only contact with the code under test,
`observer` is the best that anyone could do, `scoring` and `document` make the figures.
"""
