"""Problems as nested dicts and as TOML text. What is right is decided by the reader of problem files alone."""
import json
import re
import tomllib
from collections.abc import Mapping

BARE = re.compile(r"[A-Za-z0-9_-]+\Z")


def settings_of(text):
    """The nested dicts of a problem file's text."""
    return tomllib.loads(text)


def text_of(settings):
    """The TOML of nested dicts: a table for each section, [[...]] for lists of dicts."""
    lines, tables = [], []
    for key, value in settings.items():
        value = plain(value)
        if isinstance(value, Mapping):
            tables += ["", f"[{quoted(key)}]", *members(value)]
        elif isinstance(value, (list, tuple)) and value and all(isinstance(entry, Mapping) for entry in value):
            for entry in value:
                tables += ["", f"[[{quoted(key)}]]", *members(entry)]
        else:
            lines.append(f"{quoted(key)} = {written(value)}")
    return "\n".join(lines + tables) + "\n"


def changed(text, sections):
    """The text with other keys: dicts go key by key into what is there, None removes."""
    return text_of(merged(settings_of(text), sections))


def merged(old, new):
    result = dict(old)
    for key, value in new.items():
        if value is None:
            result.pop(key, None)
        elif isinstance(value, Mapping):
            result[key] = merged(result[key] if isinstance(result.get(key), Mapping) else {}, value)
        else:
            result[key] = value
    return result


def frozen(value):
    """Nested dicts and lists as what has a hash: equal where they are."""
    if isinstance(value, Mapping):
        return frozenset((key, frozen(entry)) for key, entry in value.items())
    return tuple(frozen(entry) for entry in value) if isinstance(value, list) else value


def members(table):
    return [f"{quoted(key)} = {written(value)}" for key, value in table.items()]


def quoted(key):
    if not isinstance(key, str):
        raise TypeError(f"keys of a problem are str, not {type(key).__name__}: {key!r}")
    return key if BARE.match(key) else json.dumps(key)


def plain(value):
    """NumPy's arrays and numbers as Python's own."""
    return value.tolist() if hasattr(value, "tolist") else value


def written(value):
    value = plain(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{" + ", ".join(members(value)) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(written(entry) for entry in value) + "]"
    raise TypeError(f"a problem holds numbers, text, lists and dicts, not {type(value).__name__}: {value!r}")
