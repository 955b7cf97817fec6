"""`python -m creak`: the command `creak`, where it is not on the path."""

from creak.cli.main import main

if __name__ == "__main__":
    main()
