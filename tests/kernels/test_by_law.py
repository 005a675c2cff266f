"""What a law says is heard: no name that nobody calls, no property that no law has."""

import re

import pytest

from nlds_vines.kernels.numerics.stored_code import KERNELS

TEXTS = {path: path.read_text(encoding="utf-8") for path in KERNELS.rglob("*.py")}
MARKED = {
    name
    for text in TEXTS.values()
    for name in re.findall(r"^@by_wall.*\ndef (\w+)", text, re.MULTILINE)
}
LAWS = sorted(p for p in TEXTS if p.parent.name == "laws" and p.stem not in ("__init__", "law"))


def idle(text):
    """Return the kernels of a law that neither take the place of another nor are called there."""
    names = re.findall(r"^def (\w+)", text, re.MULTILINE)
    return {name for name in names if len(re.findall(rf"\b{name}\b", text)) == 1} - MARKED


@pytest.mark.parametrize("path", LAWS, ids=lambda path: path.stem)
def test_each_kernel_of_a_law_is_called(path):
    assert idle(TEXTS[path]) == set()
    assert idle(TEXTS[path].replace("def made(", "def mad(")) == {"mad"}


def properties(texts):
    """Return the properties that kernels ask laws for, and those that laws assign."""
    asked = set(re.findall(r'\bsays\([\w.]+, "(\w+)"\)', "\n".join(texts)))
    assigned = {w for p in LAWS for w in re.findall(r"^([A-Z_]+) = True$", TEXTS[p], re.MULTILINE)}
    return asked, assigned


def test_each_property_that_is_asked_for_is_one_of_a_law():
    asked, assigned = properties(TEXTS.values())
    assert len(asked) > 2
    assert asked == assigned
    asked, assigned = properties([*TEXTS.values(), 'if says(near, "AT_LAST"):'])
    assert asked != assigned
