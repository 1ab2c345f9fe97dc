"""``python -m packing_forces``: the command line."""

import sys

from packing_forces.command_line import main

if __name__ == "__main__":
    sys.exit(main())
