"""The steps of the line, one module per verb; ``servogen.pipeline`` puts them in order."""
