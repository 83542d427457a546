"""Studies: a case run over crossed settings, each run's error against a truth set beside its cost."""
