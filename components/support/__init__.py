"""Support for components: compiled code, reproducible arithmetic, serialisation, checks of what people give."""
