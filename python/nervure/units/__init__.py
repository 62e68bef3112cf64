"""Units of a scene: described, packed, loaded; and as SSP or a folder for other masters."""
