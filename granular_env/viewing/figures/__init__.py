"""Figures drawn with matplotlib."""

from granular_env.optional_packages import import_optional

# Import matplotlib here first, so that if it is missing, the error names the package to install.
import_optional("matplotlib", "figures")
