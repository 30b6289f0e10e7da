"""Compilation of kernels: a cache on disk that is right by construction, what makes compiling quick, and words about it."""
