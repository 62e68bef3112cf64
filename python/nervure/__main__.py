"""`python -m nervure`: the command without its entry point."""

from nervure.cli import main

main()
