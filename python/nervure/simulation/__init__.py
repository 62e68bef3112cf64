"""A run of a scene: session, loop, recorder, checkpoints, results and sweeps."""
