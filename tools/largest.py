#!/usr/bin/env python3
"""Lists the 10 largest source files and the 10 longest functions: information, not a gate.

usage: largest.py [repository]
A file beyond 500 lines or a function beyond 60 usually mixes two rooms or two steps.
Functions are found by their braces, not by a compiler: those that start in column 0, as most do in the layout of .clang-format.
"""
import pathlib
import re
import sys

FOLDERS = ["src", "apps", "tests", "bench"]
HEAD = re.compile(r"^[A-Za-z].*\(|^TEST")
STRING = re.compile(r"\"(?:\\.|[^\"\\])*\"|'(?:\\.|[^'\\])'")
NOT_FUNCTIONS = re.compile(r"^(namespace|struct|class|enum|union|extern|using|constexpr|const|static const|inline constexpr)\b[^(]*[{=]")


def functions(lines):
    """(length, first line number, first line) of each function that starts in column 0 and ends where its braces close."""
    start, depth, opened = None, 0, False
    for number, line in enumerate(lines, 1):
        if start is None:
            if not HEAD.match(line) or NOT_FUNCTIONS.match(line):
                continue
            start, depth, opened = number, 0, False
        code = STRING.sub("", line)
        depth += code.count("{") - code.count("}")
        opened = opened or "{" in code
        if depth <= 0 and opened:
            yield number - start + 1, start, lines[start - 1]
            start = None
        elif not opened and line.rstrip().endswith(";"):
            start = None  # a declaration


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    files, found = [], []
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.[ch]pp")):
            lines = path.read_text(encoding="utf-8").splitlines()
            name = path.relative_to(root)
            files.append((len(lines), str(name)))
            found += [(length, f"{name}:{start}", head.strip()[:70]) for length, start, head in functions(lines)]
    print("largest files (lines)")
    for length, name in sorted(files, reverse=True)[:10]:
        print(f"{length:6d}  {name}")
    print("longest functions (lines)")
    for length, where, head in sorted(found, reverse=True)[:10]:
        print(f"{length:6d}  {where}  {head}")


if __name__ == "__main__":
    main()
