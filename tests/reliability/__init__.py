"""Mistreats both FMUs as files and the writing of results: docs/reference/reliability.md says what counts as right."""
