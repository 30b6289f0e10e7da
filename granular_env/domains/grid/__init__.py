"""Environments of the elastic grid."""
