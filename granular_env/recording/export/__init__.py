"""Export of a log to the formats of other programs: VTK, extended XYZ, CSV, NetCDF and HDF5."""
