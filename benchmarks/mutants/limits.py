"""Mutants: the limit of a scene, watched inside contacts."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T_CONTACT_LIMIT = "tests/kernels/test_contact_limit.py"
_T_TOUCH = "tests/kernels/plain_touch.py::"

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
    ),
    *of(
        "nlds_vines/kernels/watch/limit.py",
        (
            "limit: the limit's greatest excess is that of the first excursion",
            "best = level + limit_log[EXCESS]",
            "best = level + (1e9 if limit_log[EXCESS] > 0.0 else 0.0)",
            _T_TOUCH + "test_passages_are_counted_with_the_first_and_the_deepest",
        ),
        (
            "limit: the summit of an excursion is not looked for",
            "        top = nearest_miss(w, x, 1.0, end if stays else fall, best, bend, jerk, False)\n",
            "        top = best\n",
            _T_TOUCH + "test_passages_are_counted_with_the_first_and_the_deepest",
        ),
        (
            "limit: times in a step of a contact run evenly",
            "    return begin + column_at(piece.table, int(TAU), x)",
            "    return begin + x * column_at(piece.table, int(TAU), 1.0)",
            _T_CONTACT_LIMIT,
        ),
    ),
    *of(
        "nlds_vines/kernels/motion/taylor.py",
        (
            "taylor: a far wall stands where a near one does",
            "    k[COEF + 2] += sign * side.wall.gap",
            "    k[COEF + 2] += side.wall.gap",
            _T_CONTACT_LIMIT,
        ),
        (
            "taylor: a far wall's motion is not mirrored back",
            "COEF + 4 * n, sign * k[LENGTHS + n]",
            "COEF + 4 * n, k[LENGTHS + n]",
            _T_CONTACT_LIMIT,
        ),
    ),
    *of(
        "nlds_vines/kernels/events/contact.py",
        (
            "contact: nothing is watched inside",
            "        watch_piece(side.ps, side.damper, watch, piece, step.phase, elapsed, 1.0)",
            "        pass",
            _T_CONTACT_LIMIT,
        ),
        (
            "contact: times of the limit are those of the touch",
            "watch, piece, step.phase, elapsed, 1.0)",
            "watch, piece, step.phase, 0.0, 1.0)",
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
