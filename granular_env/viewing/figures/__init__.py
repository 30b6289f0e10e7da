"""Figures drawn with matplotlib."""

from granular_env.optional_packages import import_optional

# The error names the package to install. The modules of this folder import matplotlib as usual.
import_optional("matplotlib", "figures")
