"""Mistreatment of both FMUs as files and libraries, and of the writing of results."""
