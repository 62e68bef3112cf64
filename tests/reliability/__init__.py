"""Mistreats both FMUs as files and the writing of results: docs/reliability.md says what counts as right."""
