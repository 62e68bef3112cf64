"""The Python side of the co-simulation: packs the units, runs them together and reports.

`scene` reads a scene file, `package` makes its FMUs, `unit` wraps one FMU, `master` is the loop, `recorder` keeps what
it shows, `checkpoint` lets it go on after a crash, `fields` writes files for ParaView, `statistics` and `coefficients`
evaluate it, `report` and `plots` write the results. Everything is in SI units.
"""
