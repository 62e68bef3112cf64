"""What a run's series say: periods, coefficients, flapping."""
