"""Materials and material laws that several components share."""
