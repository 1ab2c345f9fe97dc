"""What the data of a packing or a measurement show by themselves."""

from packing.diagnosis.diagnose import diagnose

__all__ = ["diagnose"]
