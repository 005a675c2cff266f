"""Mutants: archives, parts of runs under way, and their checks."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T_LAYOUT = "tests/archives/test_layout.py::"
_T_DURABLE = "tests/archives/test_durable.py::"
_T_KEEPING = "tests/contract/test_keeping.py::"
_T_PARTS = "tests/contract/test_parts.py::"
_T_DAMAGE = "tests/contract/test_damage.py::"
_T_ARCHIVE = "tests/contract/test_archive.py::"
_T_SHARDS = "tests/contract/test_shards.py::"

MUTANTS = (
    *of(
        "nlds_vines/archives/durable.py",
        (
            "durable: a seal hashes the first slab alone",
            "        size -= len(slab)",
            "        size = 0",
            _T_DURABLE + "test_a_seal_is_of_all_bytes",
        ),
        (
            "durable: whoever reads a sealed file does not look at the seal",
            '    if sealed[-_SEAL_BYTES:] != _seal(hashlib.sha256(data)):\n        raise ValueError("its seal is broken")\n',
            "",
            _T_DURABLE + "test_a_seal_is_of_all_bytes",
        ),
        (
            "durable: a file is written in place",
            "    temporary = beside(path)\n    digest",
            "    temporary = path\n    digest",
            _T_DURABLE + "test_a_file_is_on_the_disk_before_it_takes_its_name_and_the_name_follows",
        ),
        (
            "durable: a file is not forced to the disk",
            "            file.flush()\n            os.fsync(file.fileno())\n        replace(temporary, path)",
            "            file.flush()\n        replace(temporary, path)",
            _T_DURABLE + "test_a_file_is_on_the_disk_before_it_takes_its_name_and_the_name_follows",
        ),
        (
            "durable: a rename is not forced to the disk",
            "        os.fsync(folder)",
            "        os.fstat(folder)",
            _T_DURABLE + "test_a_file_is_on_the_disk_before_it_takes_its_name_and_the_name_follows",
        ),
        (
            "durable: room on the disk is not reserved",
            "os.posix_fallocate(file.fileno(), 0, size)",
            "os.posix_fallocate(file.fileno(), 0, 1)",
            _T_DURABLE + "test_room_is_asked_for_to_the_last_byte",
        ),
        (
            "durable: an archive is replaced by what is none",
            "    if is_archive and not archive:",
            "    if False:",
            "tests/contract/test_no_file_is_lost.py::test_python_replaces_no_file_unasked_either",
        ),
        (
            "durable: a file that may not be written is replaced",
            "    if not mode & 0o222:",
            "    if False:",
            "tests/contract/test_no_file_is_lost.py::"
            "test_what_is_written_meanwhile_is_seen_by_the_writer_itself",
        ),
        (
            "durable: a lock that another removed counts",
            "        elif _is_open_as(path, descriptor):",
            "        elif True:",
            _T_DURABLE + "test_a_lock_on_a_file_that_was_removed_meanwhile_does_not_count",
        ),
        (
            "durable: a shared lock is one's own",
            "kind = fcntl.LOCK_SH if shared else fcntl.LOCK_EX",
            "kind = fcntl.LOCK_SH",
            _T_DURABLE + "test_a_lock_is_held_alone_and_a_shared_one_together",
        ),
    ),
    *of(
        "nlds_vines/archives/provenance.py",
        (
            "provenance: the names of sources do not count",
            '        digest.update(f"{path.relative_to(_PACKAGE).as_posix()}\\0".encode())\n',
            "",
            _T_DURABLE + "test_every_source_and_its_name_count",
        ),
        (
            "provenance: the sources of one folder alone count",
            '_PACKAGE.rglob("*.py")',
            '_PACKAGE.glob("*.py")',
            _T_DURABLE + "test_every_source_and_its_name_count",
        ),
        (
            "provenance: a changed clone is not told",
            'return found + ("+" if changed else "")',
            "return found",
            _T_KEEPING + "test_the_commit_is_that_of_the_clone",
        ),
        (
            "provenance: the machine does not count",
            '        "machine": platform.machine(),\n',
            "",
            _T_DURABLE + "test_what_may_change_a_bit_is_named",
        ),
    ),
    *of(
        "nlds_vines/archives/archive.py",
        (
            "archive: what was written is not read back",
            "            if crc32_of(values_of(file[name], cells)) != crc:",
            "            if len(file[name]) < 0:",
            _T_PARTS + "test_an_archive_that_differs_from_its_parts_is_not_put_in_place",
        ),
        (
            "archive: an archive of the future is read",
            "if schema is not None and schema <= SCHEMA:",
            "if schema is not None and schema <= 10**9:",
            _T_ARCHIVE + "test_an_hdf5_file_of_another_program_and_of_the_future_are_refused",
        ),
        (
            "archive: a broken seal is no problem",
            "problems = [] if sealed else [",
            "problems = [] if sealed or path else [",
            _T_DAMAGE + "test_a_changed_attribute_breaks_the_seal",
        ),
        (
            "archive: numbers are stored without checksums",
            'dtype.itemsize), "fletcher32": True}',
            "dtype.itemsize)}",
            _T_DAMAGE + "test_damage_is_named_by_dataset[E1max]",
        ),
        (
            "archive: cells without a piece are zero",
            '"fillvalue": fill,',
            '"fillvalue": None,',
            _T_ARCHIVE + "test_cells_without_a_piece_say_so",
        ),
    ),
    *of(
        "nlds_vines/archives/view.py",
        (
            "archive: strings have no checksum",
            '    if is_text(dataset) and whole_crc(dataset) != dataset.attrs.get("crc32"):',
            "    if len(dataset.shape) > 99:",
            _T_DAMAGE + "test_damage_is_named_by_dataset[label]",
        ),
    ),
    *of(
        "nlds_vines/archives/layout.py",
        (
            "layout: the checksum of strings forgets where one ends",
            '"".join(f"{text}\\0" for text in values.flat)',
            '"".join(f"{text}" for text in values.flat)',
            _T_DURABLE + "test_checksums_of_strings_tell_where_one_ends",
        ),
        (
            "layout: the checksum of a second slab forgets the first",
            'return zlib.crc32("".join(f"{text}\\0" for text in values.flat).encode(), crc)',
            'return zlib.crc32("".join(f"{text}\\0" for text in values.flat).encode())',
            _T_DURABLE + "test_checksums_go_on_from_piece_to_piece",
        ),
        (
            "layout: a dataset is read up to its first slab",
            "    for first in range(0, shape[0], step):\n        yield slice(first, min(first + step, shape[0]))",
            "    yield slice(0, min(step, shape[0]))",
            _T_DURABLE + "test_slabs_are_all_of_an_array",
        ),
    ),
    *of(
        "nlds_vines/runs/partfile.py",
        (
            "partfile: a part of another block is taken",
            '    if head["block"] != identity:\n        raise ValueError("it is of another request or another block")\n',
            "",
            _T_PARTS + "test_a_part_smuggled_in_from_another_scan_is_found",
        ),
        (
            "partfile: a part of another version is taken",
            "        if self.made.by != makers():",
            "        if not self.made.by:",
            _T_DAMAGE + "test_parts_of_another_version_of_the_program_are_computed_again",
        ),
        (
            "partfile: an array begins where the one before begins",
            "        start += count * np.dtype(dtype).itemsize",
            "        start += 0 * count",
            _T_PARTS + "test_resume_takes_verified_parts_and_ends_in_the_same_arrays",
        ),
    ),
    *of(
        "nlds_vines/runs/folder.py",
        (
            "folder: an archive that exists is replaced unasked",
            '        if not resume:\n            raise RequestError(f"{self.path} exists: --overwrite replaces it, -o names another")\n',
            "",
            _T_PARTS + "test_an_existing_archive_is_refused_and_untouched",
        ),
        (
            "folder: parts of another request are resumed",
            "        if found and found.scan_hash != self.request.hash:",
            "        if found and not found.scan_hash:",
            _T_PARTS + "test_parts_of_another_scan_are_refused_by_name_until_overwritten",
        ),
        (
            "folder: a damaged archive is complete",
            "        if problems := archive.verify(self.path):",
            "        if problems := []:",
            _T_PARTS + "test_resume_of_a_damaged_archive_is_refused",
        ),
        (
            "folder: an unfinished run is begun anew unasked",
            "        if found and not (resume or self.shard):",
            "        if found and not (resume or self.shard or self.path):",
            _T_PARTS + "test_resume_takes_verified_parts_and_ends_in_the_same_arrays",
        ),
        (
            "folder: two runs may share a folder",
            'self._lock("lock", self._busy, shared=self.shard is not None)',
            'self._lock("lock", self._busy, shared=True)',
            _T_PARTS + "test_a_second_run_is_refused_and_a_dead_ones_lock_is_gone",
        ),
    ),
    *of(
        "nlds_vines/runs/shard.py",
        (
            "shard: shares overlap",
            "return number % self.count == self.index - 1",
            "return number % self.count <= self.index - 1",
            _T_SHARDS + "test_shards_share_all_blocks_and_none_twice",
        ),
    ),
    *of(
        "nlds_vines/bifurcation/parts.py",
        (
            "parts: an array of another shape is stored",
            "            if array.shape != shape:",
            "            if array.ndim != len(shape):",
            _T_PARTS + "test_results_of_another_shape_are_a_mistake_of_the_caller",
        ),
        (
            "parts: a damaged part stays where it is",
            "                    path.unlink(missing_ok=True)\n",
            "",
            _T_DAMAGE + "test_every_flipped_bit_of_a_part_is_found_and_the_part_removed",
        ),
        (
            "parts: missing blocks are left at their fill values",
            "        missing = len(blocks) - len(self.files.there(blocks))",
            "        missing = 0",
            _T_PARTS + "test_resume_takes_verified_parts_and_ends_in_the_same_arrays",
        ),
        (
            "parts: the rectangle is no part of a part's identity",
            "            [[int(first), int(stop)] for first, stop in block.slices],\n",
            "",
            _T_PARTS + "test_a_part_of_other_cells_in_the_same_shape_is_not_taken",
        ),
    ),
    *of(
        "nlds_vines/upkeep/verify.py",
        (
            "verify: parts in excess are not told",
            '        yield f"part {name} belongs to no block of this scan"',
            "        yield from ()",
            _T_DAMAGE + "test_parts_without_their_manifest_or_in_excess_are_told",
        ),
        (
            "verify: a damaged part is sound",
            '            yield f"part {files.path(block).name} is damaged: {error}"',
            "            str(error)",
            _T_DAMAGE + "test_three_hundred_flipped_bits_are_all_found_and_told",
        ),
    ),
    *of(
        "nlds_vines/archives/structure.py",
        (
            "structure: a byte of a file stands for any number",
            "_MOST_COMPRESSED = 1100",
            "_MOST_COMPRESSED = 11000",
            _T_LAYOUT + "test_a_byte_of_a_file_stands_for_1100_values_at_most",
        ),
        (
            "structure: the bound of compression itself is refused",
            "member.bytes > _MOST_COMPRESSED * member.stored",
            "member.bytes >= _MOST_COMPRESSED * member.stored",
            _T_LAYOUT + "test_a_byte_of_a_file_stands_for_1100_values_at_most",
        ),
        (
            "structure: a scale may stand still",
            "(values[1:] > values[:-1]).all()",
            "(values[1:] >= values[:-1]).all()",
            _T_LAYOUT + "test_scales_are_finite_and_rise",
        ),
        (
            "structure: a scale may be infinite",
            "np.isfinite(values).all() and",
            "not np.isnan(values).any() and",
            _T_LAYOUT + "test_scales_are_finite_and_rise",
        ),
        (
            "structure: a scale may have sides",
            "if len(scale.shape) != 1:",
            "if len(scale.shape) < 1:",
            _T_LAYOUT + "test_a_scale_has_one_dimension",
        ),
        (
            "structure: a dataset may be shorter than its scale",
            "math.prod(members[scales[0]].shape) != length",
            "math.prod(members[scales[0]].shape) < length",
            _T_LAYOUT + "test_a_dataset_is_as_long_as_its_scales",
        ),
        (
            "structure: a dimension may have two scales",
            "if len(scales) != 1 or scales[0] not in members:",
            "if len(scales) < 1 or scales[0] not in members:",
            _T_LAYOUT + "test_each_dimension_has_one_scale_of_its_own_file",
        ),
    ),
    *of(
        "nlds_vines/archives/heaps.py",
        (
            "heaps: an entry may end behind its heap",
            "if size < _ENTRY.size or entry + size > end:",
            "if size < _ENTRY.size or entry + size > end + 1:",
            _T_LAYOUT + "test_a_heap_whose_entries_do_not_end_with_it_is_damaged",
        ),
        (
            "heaps: an entry may be shorter than its own words",
            "if size < _ENTRY.size or entry + size > end:",
            "if size < 1 or entry + size > end:",
            _T_LAYOUT + "test_a_heap_whose_entries_do_not_end_with_it_is_damaged",
        ),
        (
            "heaps: a heap may end behind its file",
            "if not entry <= end <= len(data):",
            "if not entry <= end <= len(data) + 1:",
            _T_LAYOUT + "test_a_heap_whose_entries_do_not_end_with_it_is_damaged",
        ),
        (
            "heaps: a heap may be shorter than its own words",
            "if not entry <= end <= len(data):",
            "if not end <= len(data):",
            _T_LAYOUT + "test_a_heap_whose_entries_do_not_end_with_it_is_damaged",
        ),
        (
            "heaps: the free rest counts from behind its words",
            "size = size if number == 0 else",
            "size = size if number < 0 else",
            _T_LAYOUT + "test_a_heap_whose_entries_fill_it_is_whole",
        ),
        (
            "heaps: the first heap stands for all",
            "place = data.find(_SIGN, place + len(_SIGN), end)",
            "place = -1",
            _T_LAYOUT + "test_a_heap_whose_entries_do_not_end_with_it_is_damaged",
        ),
    ),
    *of(
        "nlds_vines/archives/view.py",
        (
            "view: the checksum of strings is that of their last slab",
            "crc = crc32_of(values_of(dataset, slab), crc)",
            "crc = crc32_of(values_of(dataset, slab))",
            _T_LAYOUT + "test_a_checksum_is_of_all_slabs_in_their_order",
        ),
        (
            "view: strings without a checksum are trusted",
            'whole_crc(dataset) != dataset.attrs.get("crc32"):',
            'whole_crc(dataset) != dataset.attrs.get("crc32", whole_crc(dataset)):',
            _T_LAYOUT + "test_one_changed_string_is_noticed",
        ),
    ),
    *of(
        "nlds_vines/explore/session.py",
        (
            "session: a closed page computes on",
            "            self._job.cancel()\n\n\n_ACTIONS",
            "            pass\n\n\n_ACTIONS",
            "tests/explore/test_session.py::test_a_closed_page_leaves_nothing_running",
        ),
    ),
)
