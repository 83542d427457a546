"""Sweeps: one case over many points of its keys, run by engines that share nothing but files."""
