"""Run the command ``bristle-sim`` as ``python -m bristle_sim``."""

import sys

from bristle_sim.cli.command import main

if __name__ == "__main__":
    sys.exit(main())
