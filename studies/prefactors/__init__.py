"""How large the error is: the prefactor C of E = C ξ/Δ, and its laws."""
