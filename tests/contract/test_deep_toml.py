"""TOML of tables within tables: refused before it takes time or memory that grow as its square."""

import time

import pytest

from nlds_vines.archives.toml import MOST_LEVELS, parse_toml
from nlds_vines.errors import RequestError

DEEP = {
    "a dotted key": "a" + ".a" * 20_000 + " = 1",
    "a dotted key with blanks": '"a"' + ' . "a"' * 9_000 + " = 1",
    "a dotted key of a table": "x = {y = 1, a" + ".a" * 20_000 + " = 1}",
    "a header": "[a" + ".a" * 20_000 + "]",
    "a header of a list": "[[" + "a." * 20_000 + "a]]",
    "tables in one line": "a = " + "{a = " * 200 + "1" + "}" * 200,
    "lists": "a = " + "[" * 100 + "]" * 100,
    "keys in tables in lists": "a" + ".a" * 40 + " = [{" + "a" + ".a" * 40 + " = 1}]",
}


@pytest.mark.parametrize("case", DEEP)
def test_tables_within_tables_are_refused_at_once(case):
    began = time.process_time()
    with pytest.raises(RequestError, match="x: malformed TOML: nested too deeply"):
        parse_toml(DEEP[case], "x")
    assert time.process_time() - began < 1.0


@pytest.mark.parametrize(
    "text",
    [
        "a" + ".a" * (MOST_LEVELS - 2) + " = 1",
        't = "a' + ".a" * 1000 + '"',
        "v = [" + "1.5, " * 100_000 + "1.5]",
        't = """' + ',"aaaa' * 100_000 + '"""',
        "\n".join(f"a{i}.b.c = 1" for i in range(3000)),
    ],
)
def test_what_is_only_long_is_read(text):
    assert parse_toml(text, "x")
