"""Mistreats both FMUs as files and the writing of results, and writes docs/reliability.csv.

python scripts/studies/reliability                  everything at full count, each check in a process of its own
python scripts/studies/reliability --only forks     one check (`--list` names them); `--share 0.01` for fewer cases
"""
