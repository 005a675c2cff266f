"""Files with a checksum, and locks."""

import os

import pytest

from nlds_vines.archives import durable


@pytest.fixture
def path(tmp_path):
    return tmp_path / "file"


# ---- checksums -----------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [0, 1, 1000])
def test_a_checksum_is_of_all_bytes(path, size):
    durable.write(path, bytes(size))
    whole = path.read_bytes()
    assert durable.read(path) == bytes(size)
    for place in range(len(whole)):
        broken = bytearray(whole)
        broken[place] ^= 1
        path.write_bytes(broken)
        with pytest.raises(ValueError, match="checksum"):
            durable.read(path)
    for left in range(len(whole)):
        path.write_bytes(b"x" * left)
        with pytest.raises(ValueError, match="checksum"):
            durable.read(path)


# ---- locks ---------------------------------------------------------------------------------------


def test_a_lock_is_held_alone_and_a_shared_one_together(path):
    one = durable.lock(path)
    assert durable.held(path)
    assert durable.lock(path, patience=0.0) is None
    assert durable.lock(path, shared=True, patience=0.0) is None
    os.close(one)
    both = [durable.lock(path, shared=True) for _ in range(2)]
    assert None not in both
    assert durable.lock(path, patience=0.0) is None
    for descriptor in both:
        os.close(descriptor)


def test_a_lock_on_a_file_that_was_removed_meanwhile_does_not_count(path, monkeypatch):
    """Its holder removed it between opening and locking: others would lock another file."""
    attempts, try_lock = [], durable._try_lock

    def removed_once(descriptor, kind):
        if not attempts:
            path.unlink()
        attempts.append(descriptor)
        return try_lock(descriptor, kind)

    monkeypatch.setattr(durable, "_try_lock", removed_once)
    descriptor = durable.lock(path)
    assert descriptor is not None
    assert len(attempts) == 2
    assert os.path.samestat(os.fstat(descriptor), path.stat())
    os.close(descriptor)
