"""One run of studies or benchmarks: its edition, its packings, and where its tables go."""

from __future__ import annotations

import time
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property
from os import cpu_count
from os.path import relpath
from pathlib import Path
from typing import Any

import numpy as np

from dem import Packing
from studies.packing_store import FULL, QUICK, Edition, prepare
from studies.prefactors import collapse
from studies.tables import provenance, write_table


@dataclass(frozen=True)
class Run:
    """Tables of an edition.  A quick run never writes where the full results are kept."""

    edition: Edition
    begin: float = field(default_factory=time.perf_counter)

    @classmethod
    def of(cls, full: bool) -> Run:
        """The full edition, or the quick one."""
        return cls(FULL if full else QUICK)

    @property
    def full(self) -> bool:
        """Whether this is the edition of the docs."""
        return self.edition.name == FULL.name

    @cached_property
    def packings(self) -> list[Packing]:
        """Those of the figures, at rest."""
        some = prepare(self.edition)
        self.report("packings at rest")
        return some

    @cached_property
    def errors(self) -> np.ndarray:
        """The table of Fig. 1, on which table 1 builds."""
        return collapse.compute(self.packings, self.edition)

    def pool(self) -> ProcessPoolExecutor:
        """One process per core."""
        return ProcessPoolExecutor(cpu_count())

    def report(self, what: str) -> None:
        """A line with the seconds since the beginning."""
        print(f"{time.perf_counter() - self.begin:5.0f} s  {what}", flush=True)

    def keep(self, name: str, lines: str | Iterable[str]) -> None:
        """Write a table of words, and print it line by line as it comes."""
        self.report(f"{name}\n")
        said = []
        for line in lines.split("\n") if isinstance(lines, str) else lines:
            print(line, flush=True)
            said.append(line)
        print()
        self.edition.results.mkdir(parents=True, exist_ok=True)
        (self.edition.results / f"{name}.md").write_text("\n".join(said) + "\n")

    def write(self, name: str, table: np.ndarray, **facts: Any) -> None:
        """Write a table of numbers."""
        self._write(self.edition.results / f"{name}.csv", table, facts)

    def write_of_figure(self, name: str, table: np.ndarray, facts: dict[str, Any]) -> None:
        """Write the table of a figure, which has its own folder."""
        self._write(self.edition.figures / f"{name}.csv", table, facts)

    def _write(self, path: Path, table: np.ndarray, facts: dict[str, Any]) -> None:
        write_table(path, table, provenance(edition=self.edition.name, **facts))
        self.report(relpath(path))
