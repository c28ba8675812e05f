#!/usr/bin/env python3
"""Proves that includes between the rooms of src/ follow the one-way arrows of the table below.

usage: check_layers.py [repository]
The bindings stand above all rooms: python/src/bind_NAME.cpp includes headers of rooms and of python/src, nothing of src/ includes theirs.
Exit 0 when clean; otherwise one line for each include that breaks the rule, and exit 1.
The first thing it does is to check itself: a forbidden include must be found in a made-up source.
"""
import pathlib
import re
import sys

LEFT_OF_MECHANICS = ["lie", "fluid", "model"]
LEFT_OF_EVIDENCE = ["maneuver", "integrator", "mechanics", *LEFT_OF_MECHANICS]
LEFT_OF_GUESS = ["shape", "maneuver", "optimizer", "integrator", "mechanics", *LEFT_OF_MECHANICS]
PROOF = ["certificate", "optimality", "evidence"]
# Every source begins with algebra/operators.hpp, by CMakeLists.txt and not by its own includes; all rooms may use that room.
FOUNDATION = "algebra"
MAY_USE = {
    "algebra": [],
    "lie": [],
    "fluid": ["lie"],
    "model": ["lie", "fluid"],
    "mechanics": ["lie", "model"],
    "integrator": ["mechanics", *LEFT_OF_MECHANICS],
    "optimizer": [],
    "maneuver": ["integrator", "mechanics", *LEFT_OF_MECHANICS, "optimizer"],
    "shape": ["maneuver", "integrator", "mechanics", *LEFT_OF_MECHANICS, "optimizer"],
    "transcription": ["shape", "maneuver", "integrator", "mechanics", *LEFT_OF_MECHANICS, "optimizer"],
    "guess": ["shape", "maneuver", "integrator", "mechanics", *LEFT_OF_MECHANICS, "optimizer"],
    "evidence": LEFT_OF_EVIDENCE,
    "optimality": ["evidence", *LEFT_OF_EVIDENCE],
    "certificate": ["optimality", "evidence", *LEFT_OF_EVIDENCE],
    "search": ["guess", "transcription", *LEFT_OF_GUESS],
    "study": ["search", *PROOF, "guess", "transcription", *LEFT_OF_GUESS],
    "document": LEFT_OF_MECHANICS,
    "file": ["document", *PROOF, *LEFT_OF_GUESS],
    "result": ["file", "document", *PROOF, "guess", *LEFT_OF_GUESS],
    "task": ["result", "file", "document", "study", "search", *PROOF, "guess", "transcription", *LEFT_OF_GUESS],
    "report": ["task", "result", "file", "document", "study", "search", *PROOF, "guess", "transcription", *LEFT_OF_GUESS],
}
# What proves shares no solver code: of maneuver/ it may see only the plain structs that describe question and answer, and what
# motors give, which no solver uses.
ALLOWED_HEADERS = {(room, "maneuver"): {"maneuver/problem.hpp", "maneuver/solution.hpp", "maneuver/control_path.hpp",
                                        "maneuver/motor_limits.hpp", "maneuver/step_polynomial.hpp"} for room in PROOF}
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)


def violations(room, name, text):
    for header in INCLUDE.findall(text):
        target = header.split("/")[0]
        if target in (room, FOUNDATION):
            continue
        allowed = ALLOWED_HEADERS.get((room, target))
        if target not in MAY_USE or "/" not in header:
            yield f"{name}: includes \"{header}\": not ROOM/HEADER of a known room"
        elif target not in MAY_USE[room]:
            yield f"{name}: {room} may not use {target} (\"{header}\")"
        elif allowed is not None and header not in allowed:
            yield f"{name}: {room} may use only {', '.join(sorted(allowed))} of {target}, not \"{header}\""


def binding_violations(folder):
    """Includes of the bindings that lead neither to a room nor to their own folder."""
    for path in sorted(folder.glob("*.[ch]pp")):
        for header in INCLUDE.findall(path.read_text(encoding="utf-8")):
            room, _, rest = header.partition("/")
            if not (room in MAY_USE and rest) and not (folder / header).exists():
                yield f"{path}: includes \"{header}\": neither ROOM/HEADER of a known room nor a header beside it"


def main():
    assert list(violations("lie", "made-up", '#include "model/tree.hpp"\n')), "the check itself is broken"
    repository = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    root = repository / "src"
    found, files = [], 0
    for path in sorted(root.rglob("*.[ch]pp")):
        room = path.relative_to(root).parts[0]
        if room not in MAY_USE or len(path.relative_to(root).parts) != 2:
            found.append(f"{path}: not in a room of the table, or more than one level deep")
            continue
        files += 1
        found.extend(violations(room, str(path), path.read_text(encoding="utf-8")))
    found.extend(binding_violations(repository / "python" / "src"))
    print("\n".join(found) if found else f"layers clean: {files} files in {len(MAY_USE)} rooms")
    sys.exit(1 if found or files == 0 else 0)


if __name__ == "__main__":
    main()
