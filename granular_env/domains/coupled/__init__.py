"""Grid and automata with a common interface: the atlas of the paper that couples them."""
