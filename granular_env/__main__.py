"""``python -m granular_env``: the same as the command ``granular-env``."""

import sys

from granular_env.cli import main

sys.exit(main())
