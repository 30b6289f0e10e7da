"""Scenes and viewers for rerun."""

from granular_env.optional_packages import import_optional

# Import rerun here first, so that if it is missing, the error names the package to install.
import_optional("rerun", "the viewer")
