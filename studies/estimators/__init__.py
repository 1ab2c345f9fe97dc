"""What the estimators do with noise, and with what they are told."""
