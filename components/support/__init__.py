"""Support for components: compiled code, reproducible arithmetic, serialisation, validation of user input."""
