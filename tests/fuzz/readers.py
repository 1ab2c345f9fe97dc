"""Damaged files of every format: refused by name, or read whole; nothing else.

    python -m tests.fuzz.readers --inputs 100000 --seed 0

Small files in every format (`tests.packing.sample_files`), one of which is damaged in one way, are
read as users do. Good is a `FileProblem` with a known name and a file of the set, or a packing or
measurement with all its grains. Any other exception, a read that outlasts its limit, or half a
packing is a fault. Input k of a seed is always the same; `--only k` repeats it.
"""

from __future__ import annotations

import argparse
import gzip
import resource
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from packing.files.problem import FileProblem
from packing.note import NAMES
from packing.reading import read
from packing.record import Packing
from tests.fuzz import files
from tests.fuzz.files import Hang, Rng, limited
from tests.packing.sample_files import SAMPLES

LIMIT = 5.0
"""Seconds after which a read hangs; samples take hundredths."""
MEMORY = 4 * 1024**3
"""Bytes that the run may take: a file that asks for more is refused."""
REFUSED, PACKING, MEASUREMENT = "refused by name", "read as packings", "as measurements"
HALF, BARE, HUNG = "half a packing", "bare exceptions", "hung"
FAULTS = (HALF, BARE, HUNG)
UNCOUNTED = ("photoelastic", "yade")
"""Formats that never say how many rows there are: cut between two rows, they are measurements."""
_BLOCKS = 512
"""Bytes from which on two blocks may be swapped."""
ODD = (
    "nan", "inf", "-inf", "1e400", "1e300", "-1e300", "1e-320", "-1", "0", "-0.0", "", "abc",
    "1,5", "0x10", "1_0", "٣", "99999999999999999999", "1.5.2", "--", "1e", "#", "\t", "None",
    5000 * "1",
)  # fmt: skip
"""What may stand in the place of a number."""


def lines_cut(data: bytes, rng: Rng) -> bytes:
    """Lines are missing at the end."""
    lines = data.split(b"\n")
    return b"\n".join(lines[: int(rng.integers(len(lines)))]) + b"\n"


def lines_shuffled(data: bytes, rng: Rng) -> bytes:
    """Lines in another order, from some line on."""
    lines = data.rstrip(b"\n").split(b"\n")
    start = int(rng.integers(len(lines)))
    rest = [lines[start + k] for k in rng.permutation(len(lines) - start)]
    return b"\n".join([*lines[:start], *rest]) + b"\n"


def line_twice(data: bytes, rng: Rng) -> bytes:
    """A line stands there twice, or is missing."""
    lines = data.split(b"\n")
    k = int(rng.integers(len(lines)))
    return b"\n".join(lines[:k] + lines[k : k + 1] * int(rng.choice([0, 2])) + lines[k + 1 :])


def word_replaced(data: bytes, rng: Rng) -> bytes:
    """A word becomes something that is no number, or an odd one."""
    lines = data.split(b"\n")
    k = int(rng.integers(len(lines)))
    separator = next((s for s in (b",", b"\t", b" ") if s in lines[k]), b" ")
    words = lines[k].split(separator)
    words[int(rng.integers(len(words)))] = ODD[int(rng.integers(len(ODD)))].encode()
    lines[k] = separator.join(words)
    return b"\n".join(lines)


def words_swapped(data: bytes, rng: Rng) -> bytes:
    """Two words of a line, of names of columns say, change places."""
    lines = data.split(b"\n")
    k = int(rng.integers(min(len(lines), int(rng.choice([12, len(lines)])))))
    separator = next((s for s in (b",", b"\t", b" ") if s in lines[k]), b" ")
    words = lines[k].split(separator)
    a, b = rng.integers(len(words), size=2)
    words[a], words[b] = words[b], words[a]
    lines[k] = separator.join(words)
    return b"\n".join(lines)


def other_ends(data: bytes, rng: Rng) -> bytes:
    """Line ends of another system, or blanks at the ends."""
    ends = (b"\r\n", b"\r", b"\r\r\n", b" \n", b"\n\n", b"\x0b\n", b"\x85\n")
    return data.replace(b"\n", ends[int(rng.integers(len(ends)))])


def decimal_commas(data: bytes, rng: Rng) -> bytes:
    """Numbers with a decimal comma, with semicolons for commas or not."""
    if rng.random() < 0.5:
        data = data.replace(b",", b";")
    return data.replace(b".", b",")


def other_encoding(data: bytes, rng: Rng) -> bytes:
    """Another encoding, with a mark of its order or without, or a letter of one."""
    text = data.decode("utf-8", errors="replace")
    codes = ("utf-16", "utf-16-le", "utf-32", "utf-8-sig", "utf-7")
    k = int(rng.integers(len(codes) + 1))
    if k < len(codes):
        return text.encode(codes[k])
    at = int(rng.integers(len(data)))
    return data[:at] + b"\xb5" + data[at:]


def fewer_digits(data: bytes, rng: Rng) -> bytes:
    """Numbers written with few digits."""
    digits = int(rng.integers(1, 6))

    def short(word: bytes) -> bytes:
        try:
            return (f"%.{digits}g" % float(word)).encode() if b"." in word else word
        except ValueError:
            return word

    lines = data.split(b"\n")
    for k, line in enumerate(lines):
        separator = next((s for s in (b",", b"\t", b" ") if s in line), b" ")
        lines[k] = separator.join(short(word) for word in line.split(separator))
    return b"\n".join(lines)


def huge(data: bytes, rng: Rng) -> bytes:
    """Numbers with an exponent that was not theirs."""
    exponent = str(rng.choice([30, 100, 138, 160, 290, -100, -200])).encode()
    lines = data.split(b"\n")
    for k in range(int(rng.integers(len(lines))), len(lines)):
        lines[k] = b" ".join(
            word + b"e" + exponent
            if b"." in word and b"," not in word and b"e" not in word
            else word
            for word in lines[k].split(b" ")
        )
    return b"\n".join(lines)


def no_text(data: bytes, rng: Rng) -> bytes:
    """Random bytes, all of them or after a good beginning."""
    start = int(rng.choice([0, 64, len(data) // 2]))
    return data[:start] + rng.bytes(int(rng.integers(0, 2000)))


def packed(data: bytes, rng: Rng) -> bytes:
    """Packed by gzip, and that cut off or changed."""
    whole = gzip.compress(data)
    return (files.cut_off, files.byte_changed, lambda d, r: d)[int(rng.integers(3))](whole, rng)


DAMAGES: tuple[Callable[[bytes, Rng], bytes], ...] = (
    files.byte_changed, files.bytes_changed, files.cut_off, files.inserted, files.removed,
    files.swapped, files.zeroed, lines_cut, lines_cut, lines_shuffled, line_twice, word_replaced,
    word_replaced, word_replaced, words_swapped, other_ends, decimal_commas, other_encoding,
    fewer_digits, huge, no_text, packed,
)  # fmt: skip


class Whole(NamedTuple):
    """A sample: its files, which of them is read, with which options, and what is in it."""

    name: str
    data: dict[str, bytes]
    path: str
    options: dict[str, Any]
    found: Any


def whole_samples() -> list[Whole]:
    """Every sample, read once."""
    samples = []
    for name, write in SAMPLES.items():
        with tempfile.TemporaryDirectory() as folder:
            path, options = write(Path(folder))
            data = {file.name: file.read_bytes() for file in Path(folder).iterdir()}
            found = read(path, **options)
        names = {k: v.name for k, v in options.items() if isinstance(v, Path)}
        samples.append(Whole(name, dict(sorted(data.items())), path.name, names, found))
    return samples


def damaged(whole: Whole, rng: Rng) -> tuple[str, dict[str, bytes]]:
    """What was done to which file, and the files."""
    names = list(whole.data)
    name = names[int(rng.integers(len(names)))]
    damage = DAMAGES[int(rng.integers(len(DAMAGES)))]
    if len(whole.data[name]) <= _BLOCKS and damage is files.swapped:
        damage = lines_shuffled
    return f"{damage.__name__} of {name}", {**whole.data, name: damage(whole.data[name], rng)}


def outcome(folder: Path, whole: Whole, reading: Callable[..., Any], limit: float) -> str:
    """What comes of reading the files in the folder."""
    options = {name: folder / other for name, other in whole.options.items()}
    try:
        with limited(limit), warnings.catch_warnings():
            warnings.simplefilter("error")
            found = reading(folder / whole.path, **options)
    except Hang:
        return HUNG
    except FileProblem as refused:
        note = refused.note
        return REFUSED if note.name in NAMES and note.file in whole.data else BARE
    except Exception:
        return BARE
    return judged(found, whole)


def judged(found: Any, whole: Whole) -> str:
    """Whether all of it is there: every grain, and nearly every contact."""
    kind = PACKING if isinstance(found, Packing) else MEASUREMENT
    if whole.name == "jambashbulk":  # its contacts are not in the file
        return kind if len(found.positions) == len(whole.found.positions) else HALF
    there = [0 if thing.pairs is None else len(thing.pairs) for thing in (found, whole.found)]
    if len(found.positions) == len(whole.found.positions) and there[0] >= 0.9 * there[1]:
        return kind
    return kind if whole.name in UNCOUNTED and kind == MEASUREMENT else HALF


def fuzz(
    inputs: int, seed: int, reading: Callable[..., Any] = read, limit: float = LIMIT
) -> tuple[Counter[str], list[str]]:
    """Counts of the outcomes, and the faults: which sample, which damage, number of the input."""
    counts: Counter[str] = Counter()
    faults = []
    samples = whole_samples()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for k in range(inputs):
            whole, damage = put(folder, samples, seed, k)
            found = outcome(folder, whole, reading, limit)
            counts[found] += 1
            if found in FAULTS:
                faults.append(f"input {k} of seed {seed} ({whole.name}, {damage}): {found}")
    return counts, faults


def put(folder: Path, samples: list[Whole], seed: int, k: int) -> tuple[Whole, str]:
    """Put the files of input k there, and nothing else."""
    rng = np.random.default_rng([seed, k])
    whole = samples[k % len(samples)]
    damage, data = damaged(whole, rng)
    for old in folder.iterdir():
        old.unlink()
    for name, content in data.items():
        (folder / name).write_bytes(content)
    return whole, damage


def repeated(seed: int, k: int) -> None:
    """Read input k once more, and let its exception through."""
    with tempfile.TemporaryDirectory() as place:
        whole, damage = put(Path(place), whole_samples(), seed, k)
        options = {name: Path(place) / other for name, other in whole.options.items()}
        print(whole.name, damage)
        found = read(Path(place) / whole.path, **options)
        print(
            type(found).__name__,
            len(found.positions),
            found.pairs is not None and len(found.pairs),
        )


def main(arguments: Any = None) -> int:
    """One line of counts; 1 when there are faults, which are named."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz.readers", description="Read damaged files of every format."
    )
    parser.add_argument("--inputs", type=int, default=100_000, help="number of damaged files")
    parser.add_argument("--seed", type=int, default=0, help="of the damages")
    parser.add_argument("--only", type=int, help="repeat this input alone")
    asked = parser.parse_args(arguments)
    if asked.inputs < 1 or asked.seed < 0:
        parser.error(f"--inputs {asked.inputs} --seed {asked.seed}: at least 1 and 0")
    if asked.only is not None:
        repeated(asked.seed, asked.only)
        return 0
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    counts, faults = fuzz(asked.inputs, asked.seed)
    for fault in faults[:40]:
        print(fault)
    told = ", ".join(f"{counts[k]} {k}" for k in (REFUSED, PACKING, MEASUREMENT, *FAULTS))
    print(f"{asked.inputs} damaged files: {told}")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
