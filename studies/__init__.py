"""The evidence: what is run to show how exact, fast and robust the units are, and the pages that show it.

`python -m studies NAME` runs what is missing of a study. `engine` has the machinery, each other module one study: its
cases, what is kept of a run, the rows of its tables (columns: tables.toml), its figures. cases.toml has data of them.
"""
