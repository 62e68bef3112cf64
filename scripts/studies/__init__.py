"""Studies: each runs its cases, leaves tables and figures under docs/, and makes its pages of those tables."""
