#!/usr/bin/env python3
"""Checks that what the documents name exists.

usage: check_docs.py [repository]
 - relative links of README, CHANGELOG, CONTRIBUTING, examples/README.md and docs/ lead to files, and their #anchors to headings;
 - problem files named in them (examples/NAME.toml) exist, and so do tests and the commands of ./dev;
 - examples/README.md tells of every file beside it;
 - equations of docs/theory have one number each, in order, and every number cited in docs or sources is one of them;
 - docs/theory/README.md's table of chapters tells their equations and rooms that there are;
 - every key that the problem file's reader knows stands in docs/problem-file.md;
 - every key that solution.json is written with stands in docs/result-files.md;
 - docs/decisions/README.md lists every decision by its title;
 - docs/architecture.md's table of rooms states the arrows that tools/check_layers.py enforces, and its diagram draws them.
Exit 0 when clean; otherwise one line for each fault, and exit 1.
"""
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import check_layers  # noqa: E402

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)|src=\"([^\"]+)\"")
PROBLEM = re.compile(r"\bexamples/[\w/-]+\.toml\b")
DEV_COMMAND = re.compile(r"\./dev ([a-z-]+)")
DEFINED = re.compile(r"\*\*\((\d+)\.(\d+)\)\*\*")
CITED = re.compile(r"(?:equations?|Equations?|eq\.)\s+\(?(\d+\.\d+)\)?(?:(?:\s*(?:,|and|–|to)\s*)\(?(\d+\.\d+)\)?)?(?:(?:\s*(?:,|and|–|to)\s*)\(?(\d+\.\d+)\)?)?")
CITED_IN_DOCS = re.compile(r"(?<!\*\*)(?<![\w`])\((\d\.\d+)\)(?!\*\*)")
TEST_NAME = re.compile(r"`([A-Z]\w+)\.(\w+_\w+)`")
TEST_DEFINED = re.compile(r"^TEST(?:_[FP])?\((\w+), (\w+)\)", re.MULTILINE)
ROOM_ROW = re.compile(r"^\| `(\w+)/` \|(?:[^|]*\|)*?([^|]*)\|\s*$")


def documents(root):
    named = [root / name for name in ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "examples/README.md")]
    return [path for path in named + sorted((root / "docs").rglob("*.md")) if path.exists()]


def without_code(text):
    return re.sub(r"```.*?```", "", text, flags=re.DOTALL)


def anchors(text):
    for heading in re.findall(r"^#+ (.+)$", without_code(text), re.MULTILINE):
        yield re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def broken_links(path, text):
    for target in (a or b for a, b in LINK.findall(without_code(text))):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        file = path.parent / name if name else path
        if not file.exists():
            yield f"{path}: link to {target}: no such file"
        elif anchor and anchor not in anchors(file.read_text(encoding="utf-8")):
            yield f"{path}: link to {target}: no such heading"


KNOWN_KEYS = re.compile(r"allow_only\(\s*\{(.*?)\}\s*\)", re.DOTALL)
# .add("key", members by a helper add_…("key", names of arrays, and \"key\": in the text of an object
WRITTEN_KEYS = re.compile(r'\badd\w*\("(\w+)"|\bnamed\([^,]*, "(\w+)"|\bShapedArray(?: \w+)?\{"\w*", "(\w+)"|\\"(\w+)\\":')
WRITERS = ("solution_writer.cpp", "limits_json.cpp", "result_shapes.cpp")


def words_in_backticks(page):
    return set(re.findall(r"\w+", " ".join(re.findall(r"`([^`]*)`", without_code(page.read_text(encoding="utf-8"))))))


def undocumented_keys(root):
    page = root / "docs" / "problem-file.md"
    told = words_in_backticks(page)
    for source in sorted((root / "src" / "file").glob("problem_*.cpp")):
        for keys in KNOWN_KEYS.findall(source.read_text(encoding="utf-8")):
            for key in re.findall(r'"(\w+)"', keys):
                if key not in told:
                    yield f"{page}: does not tell of the key {key}, which {source.name} reads"


def untold_results(root):
    page = root / "docs" / "result-files.md"
    told = words_in_backticks(page)
    for name in WRITERS:
        found = WRITTEN_KEYS.findall((root / "src" / "result" / name).read_text(encoding="utf-8"))
        keys = sorted({key for groups in found for key in groups if key})
        if not keys:
            yield f"{page}: found no key that {name} writes"
        for key in keys:
            if key not in told:
                yield f"{page}: does not tell of the key {key}, which {name} writes"


def missing_problems(root, path, text):
    return (f"{path}: names {name}, which does not exist" for name in sorted(set(PROBLEM.findall(text)))
            if not (root / name).exists())


def unknown_commands(path, text, menu):
    return (f"{path}: names ./dev {name}, which the menu lacks" for name in sorted(set(DEV_COMMAND.findall(text)))
            if name not in menu)


def unknown_tests(path, text, tests):
    return (f"{path}: names the test {suite}.{name}, which does not exist"
            for suite, name in sorted(set(TEST_NAME.findall(text))) if (suite, name) not in tests)


def equation_faults(root):
    """Numbers defined twice, out of order, or cited and not defined."""
    defined, faults = [], []
    for path in sorted((root / "docs" / "theory").glob("[0-9]*.md")):
        numbers = [(int(a), int(b)) for a, b in DEFINED.findall(path.read_text(encoding="utf-8"))]
        chapter = int(path.name.split("-")[0])
        if numbers != [(chapter, k + 1) for k in range(len(numbers))]:
            faults.append(f"{path}: equations are not numbered ({chapter}.1), ({chapter}.2), … without gap: {numbers}")
        defined += [f"{a}.{b}" for a, b in numbers]
    cites = {path: CITED_IN_DOCS for path in (root / "docs").rglob("*.md")}
    for folder in ("src", "apps", "tests", "bench"):
        cites.update({path: CITED for path in (root / folder).rglob("*.[ch]pp")})
    for path, pattern in sorted(cites.items()):
        for found in pattern.findall(path.read_text(encoding="utf-8")):
            for number in (found,) if isinstance(found, str) else filter(None, found):
                if number not in defined:
                    faults.append(f"{path}: cites equation {number}, which docs/theory does not define")
    return faults


CHAPTER_ROW = re.compile(r"^\| \[(\d+) [^]]*\]\(([\w.-]+)\) \|[^|]*\| ([^|]*) \| ([^|]*) \|$", re.MULTILINE)


def chapter_faults(root):
    """Rows of the table of chapters: | [1 Title](file) | says | (1.1) – (1.9) | `room/` |."""
    page, faults, told = root / "docs" / "theory" / "README.md", [], set()
    for chapter, name, stated, rooms in CHAPTER_ROW.findall(page.read_text(encoding="utf-8")):
        told.add(name)
        count = len(DEFINED.findall((page.parent / name).read_text(encoding="utf-8")))
        expected = f"({chapter}.1) – ({chapter}.{count})" if count else "–"
        if stated != expected:
            faults.append(f"{page}: tells {stated} of chapter {chapter}, which has {expected}")
        faults += [f"{page}: chapter {chapter} is of {room}/, no room"
                   for room in re.findall(r"`(\w+)/`", rooms) if not (root / "src" / room).is_dir()]
    return faults + [f"{page}: does not tell of {path.name}" for path in sorted(page.parent.glob("[0-9]*.md"))
                     if path.name not in told]


def untold_examples(root):
    page = root / "examples" / "README.md"
    told = set(re.findall(r"\]\(([\w./-]+)\)", page.read_text(encoding="utf-8")))
    for file in sorted((root / "examples").rglob("*.*")):
        name = file.relative_to(page.parent).as_posix()
        if "__pycache__" not in name and file != page and name not in told:
            yield f"{page}: does not tell of {name}"


DECISION_ROW = re.compile(r"^\| \[(\d{3})\]\(([\w.-]+)\) \| (.*?) \|", re.MULTILINE)


def decision_faults(root):
    """Rows | [001](file) | title |, in order, against the files' first lines."""
    page = root / "docs" / "decisions" / "README.md"
    told = [(name, f"# {number}: {title}") for number, name, title in DECISION_ROW.findall(page.read_text(encoding="utf-8"))]
    found = [(path.name, path.read_text(encoding="utf-8").splitlines()[0]) for path in sorted(page.parent.glob("[0-9]*.md"))]
    return [f"{page}: states {row}" for row in told if row not in found] + \
           [f"{page}: does not tell {row}" for row in found if row not in told]


def uses_of(cell):
    """Rooms named in a cell "shape, optimizer, not fluid": those at the ends of arrows, those that do not come along."""
    names = [name.strip() for name in cell.split(",") if re.search(r"\w", name)]
    return {name for name in names if not name.startswith("not ")}, {name[4:] for name in names if name.startswith("not ")}


def room_faults(root):
    """Rows `room/` | what | uses, and the diagram's arrows, against the table that check_layers.py enforces."""
    page, enforced = root / "docs" / "architecture.md", check_layers.MAY_USE
    text = page.read_text(encoding="utf-8")
    rows = dict(match.groups() for line in text.splitlines() if (match := ROOM_ROW.match(line)))
    faults, arrows = [], set()
    for room in sorted(set(rows) | set(enforced)):
        if room not in rows or room not in enforced:
            faults.append(f"{page}: {room}/ is in one of the table and tools/check_layers.py alone")
            continue
        ends, out = uses_of(rows[room])
        arrows |= {(room, end) for end in ends}
        stated = ends.union(*(enforced.get(end, []) for end in ends)) - out
        if stated != set(enforced[room]):
            faults.append(f"{page}: {room}/ states {sorted(stated)}, tools/check_layers.py enforces {sorted(enforced[room])}")
    drawn = set(re.findall(r"^ +(\w+) --> (\w+)$", text, re.MULTILINE))
    return faults + [f"{page}: {room} --> {end} stands in one of table and diagram alone" for room, end in sorted(arrows ^ drawn)]


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    made_up = "[a](no/such/file.md) and `examples/no_such.toml`"
    assert list(broken_links(root / "made-up.md", made_up)) and list(missing_problems(root, "made-up", made_up))
    menu = re.findall(r"^  ([a-z-]+) ", subprocess.run([root / "dev"], capture_output=True, text=True, check=True).stdout, re.MULTILINE)
    tests = {pair for file in (root / "tests").rglob("*.cpp") for pair in TEST_DEFINED.findall(file.read_text(encoding="utf-8"))}
    found = equation_faults(root) + chapter_faults(root) + room_faults(root) + decision_faults(root) + [*untold_examples(root), *undocumented_keys(root), *untold_results(root)]
    paths = documents(root)
    for path in paths:
        text = path.read_text(encoding="utf-8")
        found += [*broken_links(path, text), *missing_problems(root, path, text), *unknown_commands(path, text, menu),
                  *unknown_tests(path, text, tests)]
    print("\n".join(found) if found else f"documents clean: {len(paths)} files")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
