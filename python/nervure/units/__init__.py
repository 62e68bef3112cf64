"""Units to hand out: FMUs, SSP, a folder of both."""
