"""Errors of the data: noise of any covariance, and systematic errors."""
