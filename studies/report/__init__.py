"""The report: what is measured (`cases`), how (`measure`, `worker`), what the other studies have (`collect`), what
is shown (`render`)."""
