"""Wave and fracture experiments in granular and heterogeneous media, as stepping components."""
