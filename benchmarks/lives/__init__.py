"""How well remaining life is foretold: histories, the observer that knows how they are drawn, scores and the document. `python -m benchmarks.lives`."""
