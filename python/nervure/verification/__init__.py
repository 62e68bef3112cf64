"""Error bars of a scene: which runs show them, what follows from the runs, and what is shown of it."""
