"""`python -m nervure`: the command without its entry point."""

from nervure.cli.main import main

main()
