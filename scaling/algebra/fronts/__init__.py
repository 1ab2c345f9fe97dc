"""Cholesky factors of sparse matrices whose unknowns lie in the plane, front by front."""
