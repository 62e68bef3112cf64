"""The Python side of the co-simulation: packs the units, runs them together and reports.

`scene` reads a scene file, `package` makes its FMUs, `unit` wraps one FMU, `coupling` is what happens in a step, `master` is
the loop, `recorder` keeps what it shows, `checkpoint` lets it go on after a crash, `fields` writes files for ParaView;
`simulation` is all of that from a scene to its results. `statistics` and `coefficients` evaluate a run, `report` and
`plots` write the results, `results` reads them again, `animation` and `inspection` show them. `delivery` and `ssp` hand the units out, and
`sweep` runs grids of scenes.
Everything is in SI units.
"""
