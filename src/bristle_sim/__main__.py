"""The command ``bristle-sim``, also run by ``python -m bristle_sim``."""

import sys


def main() -> int:
    """Run the command and return its exit status.

    An interrupt by the user, even while modules are being imported, ends in one line of output.
    """
    try:
        from bristle_sim.cli.command import main as command

        return command()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
