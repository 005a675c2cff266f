"""A thousand request files that were damaged: keys, values, bytes."""

import random
import tomllib
from pathlib import Path

import pytest
from fuzz.rule import CASES, VALUES, broken_by, command, short

from nlds_vines.archives.toml import read_toml, toml_text

pytestmark = pytest.mark.long

FILES = sorted((Path(__file__).parents[2] / "scans").glob("*.toml"))
COMMANDS = ("bifurcation", "portrait", "tuning", "continuation", "response-curves")


def tables(document):
    """Return all tables in a document, and in its lists."""
    found = [document]
    for value in document.values():
        for each in value if isinstance(value, list) else [value]:
            found += tables(each) if isinstance(each, dict) else []
    return found


def damaged(rng, path):
    """Return the text of a file with a few changes."""
    text = path.read_text()
    for _ in range(rng.randint(1, 3)):
        try:
            document = tomllib.loads(text)
        except ValueError:
            break
        table = rng.choice(tables(document))
        key = rng.choice(sorted(table) or ["x"])
        kind = rng.randrange(4)
        if kind == 0:
            table[key] = rng.choice([value for value in VALUES if value is not None])
        elif kind == 1:
            table.pop(key, None)
        elif kind == 2:
            table[rng.choice(["x", key[::-1], key.upper(), "a b", "é"])] = table.get(key, 1)
        else:
            text = cut(rng, text)
            break
        text = text_of(document) or cut(rng, text)
    return text


def text_of(document):
    """Return a document as text, '' where TOML has no words for it."""
    try:
        return toml_text(document)
    except (TypeError, ValueError, OverflowError):
        return ""


def cut(rng, text):
    """Return a text with some of its characters lost, doubled or exchanged."""
    places = sorted(rng.sample(range(len(text) + 1), 2))
    odd = rng.choice(["", "\0", "\n", "[", "]]", '"', "=", "é", "nan", "1e999", "#", text[:200]])
    return text[: places[0]] + odd + text[rng.choice(places) :]


def test_no_request_breaks_the_rule(here):
    rng, wrong = random.Random(2), []
    for number in range(CASES):
        path, name = rng.choice(FILES), rng.choice(COMMANDS)
        text = damaged(rng, path)
        Path("r.toml").write_text(text, encoding="utf-8", errors="surrogateescape")
        found = broken_by(command([name, "r.toml", "--dry-run", "--quiet"]), here)
        if found:
            wrong.append(f"case {number}: {name}, {path.name}: {found}\n{short(text)}")
    assert not wrong, "\n".join(wrong)


def test_the_files_themselves_are_read():
    assert len(FILES) > 30
    assert all(read_toml(path) for path in FILES)
