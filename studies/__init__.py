"""Measurements of the accuracy, speed and robustness of the units, and the tables and figures that show them.

`python -m studies NAME` runs the missing cases of a study. `engine` runs cases, `store` records results, `catalogue`
lists the studies; every other module is a study or a part of one: its cases, the values of a run, its tables (columns:
tables.toml) and its figures. cases.toml has data of the studies.
"""
