"""Scenes for rerun and its viewers."""

from granular_env.optional_packages import import_optional

# Its error names the package to install; the modules of this folder import rerun as usual.
import_optional("rerun", "the viewer")
