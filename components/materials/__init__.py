"""Materials and material laws shared by several components."""
