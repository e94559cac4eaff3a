"""`python -m evastudio`: the command line."""

from evastudio.cli import main

if __name__ == "__main__":
    main()
