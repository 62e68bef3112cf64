"""The report of docs/report: `pages` measures and shows error against run time, `leave_out` what absent parts cost."""
