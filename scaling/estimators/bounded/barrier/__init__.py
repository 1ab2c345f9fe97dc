"""The program of `bounded` by a barrier method that knows where contacts lie."""
