"""Scenes and viewers for rerun."""

from granular_env.optional_packages import import_optional

# The error names the package to install. The modules of this folder import rerun as usual.
import_optional("rerun", "the viewer")
