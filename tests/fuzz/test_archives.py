"""A thousand damaged archives: bytes that were flipped, cut or cleared."""

import random
import shutil

import pytest
from contract.made_up import MAP, make_scan, write
from fuzz.rule import CASES, broken_by, command, short

pytestmark = pytest.mark.long

ASKED = (
    ["plot", "--show", "?"], ["export", "-o", "c.csv"],
    ["rerun", "-o", "r.h5", "--dry-run"],
)  # fmt: skip


def spoil(rng, path):
    """Damage the bytes of a file; return what was done."""
    data = bytearray(path.read_bytes())
    kind = rng.randrange(4)
    at, length = rng.randrange(len(data)), rng.randint(1, 4096)
    if kind == 0:
        for _ in range(rng.randint(1, 8)):
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    elif kind == 1:
        del data[at:]
    elif kind == 2:
        data[at : at + length] = bytes(len(data[at : at + length]))
    else:
        data[at : at + length] = rng.randbytes(len(data[at : at + length]))
    path.write_bytes(data)
    return ("flipped", "cut", "cleared", "overwritten")[kind], at, length


def test_no_archive_breaks_the_rule(here):
    write(here / "o.h5", make_scan(("section", "energy", "regime"), vary=MAP))
    rng, wrong = random.Random(3), []
    for number in range(CASES):
        path = here / "a.h5"
        shutil.copy("o.h5", path)
        done = spoil(rng, path)
        name, *rest = rng.choice(ASKED)
        if found := broken_by(command([name, "a.h5", *rest]), here):
            wrong.append(f"case {number}: {name} after {short(done)}: {found}")
        for each in here.iterdir():
            if each.name not in ("o.h5", "a.h5"):
                each.unlink()
    assert not wrong, "\n".join(wrong)
