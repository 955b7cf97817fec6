"""Universal files, read back."""

from __future__ import annotations


def data_sets(path):
    """(number, lines) of every data set; each lies between two lines of `    -1`."""
    lines = path.read_bytes().decode("ascii").split("\r\n")
    marks = [i for i, line in enumerate(lines) if line == "    -1"]
    assert len(marks) % 2 == 0
    assert all(len(line) <= 80 for line in lines)
    return [(int(lines[a + 1][:6]), lines[a + 2 : b]) for a, b in zip(marks[::2], marks[1::2], strict=True)]


def fields(line, width):
    return [line[i : i + width] for i in range(0, len(line), width)]
