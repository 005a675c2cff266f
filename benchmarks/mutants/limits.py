"""Mutants: the limit of a scene, watched inside contacts."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T_CONTACT_LIMIT = "tests/kernels/test_contact_limit.py"

MUTANTS = (
    *of(
        "nlds_vines/kernels/watch/limit.py",
        (
            "limit: times in a contact count from the period's beginning",
            "        limit_log[ORIGIN] = time\n",
            "        pass\n",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: a contact that cannot be beyond leaves the log beyond",
            "            limit_log[BEYOND] = 0.0\n",
            "            pass\n",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: a far wall beyond the limit is not told",
            "        return -wall.gap > limit_log[LIMIT]\n",
            "        return False\n",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: no contact may reach it",
            "    return room <= 0.0 or 2.0 * stored(wall, wall.K, room, root_of(wall, room)) <= scale * scale",
            "    return False",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: a contact may reach it only where it begins beyond",
            "    return room <= 0.0 or 2.0 * stored(wall, wall.K, room, root_of(wall, room)) <= scale * scale",
            "    return room <= 0.0",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: a contact goes no deeper than where it is",
            "    deepest = z + fast * duration",
            "    deepest = z",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: the bend in a contact forgets the wall",
            "    return bend_of(ps, damper) * scale + most_push(ps, phase) + pushed",
            "    return bend_of(ps, damper) * scale + most_push(ps, phase)",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: the bend in a contact forgets the forcing",
            "    return bend_of(ps, damper) * scale + most_push(ps, phase) + pushed",
            "    return bend_of(ps, damper) * scale + pushed",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: the bend in a contact forgets the motion",
            "    return bend_of(ps, damper) * scale + most_push(ps, phase) + pushed",
            "    return abs(ps.force) + pushed",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: the energy of a contact is left out",
            "    scale = math.sqrt(scale * scale + 2.0 * stored(wall, wall.K, z, q))\n",
            "",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: a step stays between its ends",
            "    level, least, most = limit_log[LIMIT], min(r, z) - sag, max(r, z) + sag",
            "    level, least, most = limit_log[LIMIT], min(r, z), max(r, z)",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: every step is monotone",
            "            monotone = alike(s, after[1]) and abs(s) + abs(after[1]) > bend * took",
            "            monotone = True",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: an excursion in a contact never ends",
            "        limit_log[BEYOND] = 1.0 if z > level else 0.0",
            "        limit_log[BEYOND] = 1.0",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: the excess of a step is that of its end",
            "        limit_log[EXCESS] = max(limit_log[EXCESS], max(r, z) - level)",
            "        limit_log[EXCESS] = max(limit_log[EXCESS], z - level)",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: the search within a step changes the step",
            "    restore(k)\n",
            "    pass\n",
            _T_CONTACT_LIMIT,
        ),
        (
            "limit: a passage is where the first secant says",
            "        if f == 0.0 or min(at - low, high - at) < NEAR_PASSAGE:\n            break\n",
            "        break\n",
            _T_CONTACT_LIMIT,
        ),
    ),
    *of(
        "nlds_vines/kernels/events/contact.py",
        (
            "contact: the limit is not watched inside",
            "        note_limit_step(side, watch.limit_log, step, elapsed)",
            "        pass",
            _T_CONTACT_LIMIT,
        ),
        (
            "contact: times of the limit are those of the touch",
            "        note_limit_step(side, watch.limit_log, step, elapsed)",
            "        note_limit_step(side, watch.limit_log, step, 0.0)",
            _T_CONTACT_LIMIT,
        ),
    ),
    *of(
        "nlds_vines/kernels/orbit/orbit.py",
        (
            "orbit: the limit's times in flight count from the contact before",
            "                    begin_log(limit_log, began)\n",
            "",
            _T_CONTACT_LIMIT,
        ),
    ),
)
