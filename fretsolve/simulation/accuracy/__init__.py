"""Ask for an accuracy: solve in rounds, each finer than the one before, until the error bars prove the accuracy."""
