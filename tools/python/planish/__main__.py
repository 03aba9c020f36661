"""python -m planish: the program."""

from ._program import main

main()
