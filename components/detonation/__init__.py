"""A reactive gas in a tube, in one dimension."""
