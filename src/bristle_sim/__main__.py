"""The command ``bristle-sim``, also run by ``python -m bristle_sim``."""

import sys


def main() -> int:
    """Run the command and return its exit status.

    If the user interrupts the program, even during the import of modules, it prints a single line.
    """
    try:
        from bristle_sim.cli.command import main as command

        return command()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
