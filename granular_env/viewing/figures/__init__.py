"""Pictures by matplotlib."""

from granular_env.optional_packages import import_optional

# Its error names the package to install; the modules of this folder import matplotlib as usual.
import_optional("matplotlib", "figures")
