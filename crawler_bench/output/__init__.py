"""Numbers become files that a person opens: CSV, LaTeX, figures, films."""
