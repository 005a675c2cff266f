"""Mutants: contact field, impact, Runge-Kutta steps."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T_VARIATIONS = "tests/kernels/test_variations.py::"
_T_THROUGH = "tests/kernels/test_impact_variations.py::"
_T_IMPACT = "tests/kernels/plain_impact.py::"
_T_IMPACT_ERROR = "tests/kernels/test_impact_error.py::"
_PLAIN_INSIDE = "tests/kernels/plain_inside.py::"
_PLAIN_CONTACT = "tests/kernels/plain_contact.py::"
_T_ORDER = "tests/reference/test_order.py::"
_T_EXACT_FACTS = "tests/reference/test_exact_facts.py::"
_PLAIN_LAWS = "tests/kernels/plain_contact_laws.py::"
_PLAIN_LOADS = "tests/kernels/plain_loads.py::"
_PLAIN_METHODS = "tests/property/plain_methods.py::"
_T_RESTITUTION = "tests/kernels/test_restitution.py::"
_T_LAWS = "tests/kernels/test_contact_laws.py::"
_PLAIN_METHODS = "tests/property/plain_methods.py::"

MUTANTS = (
    *of(
        "nlds_vines/kernels/laws/restitution.py",
        (
            "restitution: impacts take no energy",
            "s = -wall.e * s\n",
            "s = -s\n",
            _T_RESTITUTION
            + "test_an_impact_keeps_momentum_and_takes_its_share_of_energy[0.6-ssul-set6]",
        ),
        (
            "restitution: with e = 0 every impact ends in rest, for variations",
            "    if stuck:\n        own",
            "    if s == 0.0:\n        own",
            "tests/kernels/test_bouncing_ball.py::"
            "test_an_inelastic_ball_that_is_left_at_once_forgets_its_speed_alone[3.7]",
        ),
        (
            "restitution: the structure feels no impact",
            "v1 = u + damper.share * s\n",
            "v1 = sign * now[3]\n",
            _T_RESTITUTION
            + "test_an_impact_keeps_momentum_and_takes_its_share_of_energy[1.0-ssbl]",
        ),
        (
            "restitution: rebounds end ten thousand times too early",
            "BRIEF = 1.0e-5",
            "BRIEF = 1.0e-1",
            _T_RESTITUTION
            + "test_a_damper_that_chatters_to_rest_leaves_the_common_motion_alone[-0.02-500.0]",
        ),
        (
            "restitution: a wall pulls before it lets go",
            "PULL = 1.0e-12",
            "PULL = 1.0e-3",
            _T_RESTITUTION + "test_sticking_ends_where_the_stop_would_pull",
        ),
        (
            "restitution: variations meet the wall when the orbit does",
            "late = (-1.0 / s) * r\n",
            "late = 0.0 * r\n",
            _T_RESTITUTION
            + "test_monodromy_is_the_derivative_of_the_flow[an impact a period-exact]",
        ),
        (
            "restitution: the dashpot takes no notice of the way back to the wall",
            "way = ps.damping * (1.0 - damper.share) * damper.share",
            "way = 0.0",
            _T_RESTITUTION
            + "test_monodromy_is_the_derivative_of_the_flow[it rests on the wall-exact]",
        ),
        (
            "restitution: energies of a damper that stays are not looked at",
            "    watch_piece(side.ps, side.damper, watch, grid, phase, begin, end)\n",
            "    pass\n",
            _T_RESTITUTION + "test_a_damper_pressed_to_the_wall_comes_to_rest_there[0.5]",
        ),
    ),
    *of(
        "nlds_vines/kernels/laws/hertz.py",
        (
            "force law: variations see no stiffness of the contact",
            "1.5 * wall.K * k",
            "1.0 * wall.K * k",
            _T_VARIATIONS + "test_monodromy_is_the_derivative_of_the_flow[an impact a period-rk4]",
        ),
        (
            "force law: the force of an impact grows as its depth",
            "stiffness * depth * math.sqrt(depth)",
            "stiffness * depth",
            _PLAIN_METHODS + "test_both_methods_note_the_same[ssul]",
        ),
    ),
    *of(
        "nlds_vines/kernels/laws/power.py",
        (
            "force law: damping attracts",
            "acts = 1.0 if positive else 0.0",
            "acts = 1.0",
            _T_LAWS + "test_a_damped_contact_never_attracts",
        ),
        (
            "force law: variations feel no damping",
            "return wall.damping.a * wall.K * k[SERIES + COLUMNS * n + ELASTIC]",
            "return 0.0",
            _PLAIN_LAWS + "test_variations_are_the_derivative_of_the_flow[hunt-crossley]",
        ),
        (
            "force law: the power of the stiffness is that of the force",
            "k[SERIES + COLUMNS * n + POWERS_OF_Q + wall.high - wall.root]",
            "k[SERIES + COLUMNS * n + POWERS_OF_Q + wall.high]",
            _PLAIN_LAWS + "test_variations_are_the_derivative_of_the_flow[n = 1.2]",
        ),
    ),
    *of(
        "nlds_vines/kernels/motion/once_rounded.py",
        (
            "once rounded: a cell's matrix has plain precision",
            "w[i + c], w[i + 4 + c] = head, rest + second",
            "w[i + c], w[i + 4 + c] = head, rest",
            _T_LAWS + "test_an_undamped_linear_contact_keeps_all_energy[start1-changes1]",
        ),
        (
            "once rounded: what the sums of a piece have lost is forgotten",
            "return numbers_of(total + (small * x + (lost + more)))",
            "return numbers_of(total + (lost + more))",
            "tests/kernels/test_once_rounded.py::test_so_is_a_piece_of_one[damper-0.77]",
        ),
    ),
    *of(
        "nlds_vines/kernels/laws/linear_contact.py",
        (
            "linear contact: a variation is not moved on where the force jumps",
            "late = (way * wall.cc) * r",
            "late = 0.0 * r",
            _PLAIN_LAWS + "test_variations_are_the_derivative_of_the_flow[damped]",
        ),
        (
            "linear contact: the dashpot is forgotten where the force is to vanish",
            "watched[i] = -sign * (stiffness * w[i] + drag * w[i + 1])",
            "watched[i] = -sign * (stiffness * w[i])",
            _T_LAWS + "test_a_linear_stop[1.5]",
        ),
        (
            "linear contact: the damper leaves as if it were out at once",
            "return RETURNED, again",
            "return CLEARED, again",
            _T_LAWS + "test_a_wall_pushes_again_before_the_mass_is_out",
        ),
        (
            "linear contact: volumes shrink as in flight",
            "k[contact_series.SHRUNK] -= wall.cc * damper.inv_mu * took",
            "k[contact_series.SHRUNK] -= 0.0 * took",
            _T_LAWS + "test_what_contacts_take_of_volumes_is_known[damped]",
        ),
        (
            "linear contact: the balance of the springs is that of the wall's alone",
            "wall.kc / (damper.k2 + wall.kc)",
            "1.0",
            _T_LAWS + "test_as_the_twin_finds_it[linear]",
        ),
        (
            "linear contact: the greatest force is that at the greatest depth",
            "note_force(watch.impacts, greatest(wall.kc, wall.cc, balance, sign, w, end))",
            "note_force(watch.impacts, greatest(wall.kc, 0.0, balance, sign, w, end))",
            _T_LAWS + "test_as_the_twin_finds_it[damped]",
        ),
    ),
    *of(
        "nlds_vines/kernels/scene/drive.py",
        (
            "drive: the phase stands still in a step",
            "k[row + COSINE], k[row + SINE] = -turn * sine, turn * cosine",
            "k[row + COSINE], k[row + SINE] = 0.0 * sine, 0.0 * cosine",
            _T_ORDER + "test_stepped_contact_has_order_fourteen",
        ),
    ),
    *of(
        "nlds_vines/kernels/motion/taylor.py",
        (
            "taylor: the force on the structure is that of its first instant",
            "    k[behind + AT_V], k[behind + AT_X] = per * number_of(sums, 1), per * number_of(sums, 2)\n",
            "    k[behind + AT_V], k[behind + AT_X] = per * number_of(sums, 1) * (n < 9), per * number_of(sums, 2)\n",
            _T_ORDER + "test_stepped_contact_has_order_fourteen",
        ),
        (
            "taylor: by rk4 the polynomials end with the third power",
            "    return ORDER_OF_RK4\n",
            "    return ORDER_OF_RK4 - 1\n",
            _T_ORDER + "test_the_contact_of_rk4_has_order_four",
        ),
        (
            "taylor: no step is doubted",
            "    return h * (missing / fast + late + off) / (order_of(side.rk4) + 1.0)",
            "    return 0.0 * h * (missing / fast + late + off) / (order_of(side.rk4) + 1.0)",
            "tests/kernels/test_contact_error.py::test_the_doubt_is_never_below_a_third_of_the_error",
        ),
        (
            "taylor: nothing is missed of the speed",
            "missing = abs(number_of(motion, AT_S) - weight * ds) + abs(v - weight * dv)",
            "missing = abs(v - weight * dv)",
            _PLAIN_CONTACT + "test_a_wrong_series_is_doubted",
        ),
    ),
    *of(
        "nlds_vines/kernels/impact/impact_variations.py",
        (
            "impact variations: the structure stands still until the wall is met",
            "    x, v, _, speed = carried((x, v, r, speed), (v1, dv, s, ds), late)",
            "    x, v, _, speed = carried((x, v, r, speed), (0.0, dv, s, ds), late)",
            _T_THROUGH + "test_variations_err_by_the_tolerance[1e-09]",
        ),
        (
            "impact variations: the common motion does not move its spring",
            "ps.stiffness * (x + w[TIMES + i] * v)",
            "ps.stiffness * x",
            _T_THROUGH + "test_variations_err_by_the_tolerance[1e-09]",
        ),
        (
            "impact variations: what the nodes miss is that of the orbit",
            "    b, t = b + more, t + longer\n",
            "",
            _T_THROUGH + "test_variations_err_by_the_tolerance[1e-09]",
        ),
        (
            "impact variations: one sweep is enough",
            "if left + largest_of(of_speed * of_b / size) <= enough:",
            "if left + largest_of(of_speed * of_b / size) >= 0.0:",
            _T_THROUGH + "test_variations_err_by_the_tolerance[1e-12]",
        ),
    ),
    *of(
        "nlds_vines/kernels/impact/impact_variations.py",
        (
            "impact variations: the impact feels no load",
            "push = under(ps.load, push - (a1 * z + a2 * s))",
            "push = push - (a1 * z + a2 * s)",
            _PLAIN_LOADS + "test_its_variations_are_those_of_small_steps[30.0]",
        ),
    ),
    *of(
        "nlds_vines/kernels/events/contact.py",
        (
            "contact: whatever a step misses is believed",
            "                if not doubt > share or attempt > MOST_REPEATS:",
            "                if attempt >= 0:",
            _PLAIN_CONTACT + "test_steps_that_are_foreseen_much_too_long_are_found_out[1e-09]",
        ),
        (
            "contact: a wall that has let go does not push again",
            "        positive = positive != switches\n",
            "        positive = positive and not switches\n",
            _PLAIN_LAWS + "test_variations_where_a_wall_lets_go_or_pushes_again[-0.1-start1]",
        ),
    ),
    *of(
        "nlds_vines/kernels/events/contact_step.py",
        (
            "contact: a wall lets go at the end of a step",
            "    step = part_of(step, x)\n",
            "    pass\n",
            _PLAIN_LAWS + "test_a_wall_lets_go_at_an_instant[1e-09]",
        ),
    ),
    *of(
        "nlds_vines/kernels/impact/impact.py",
        (
            "impact: the common motion feels no force",
            "    common = with_shaking(ps, (1.0 - damper.share) * push, drive)\n",
            "    common = with_shaking(ps, 0.0 * push, drive)\n",
            _T_IMPACT + "test_a_short_impact_errs_by_less_than_the_tolerance[1e-09]",
        ),
        (
            "impact: the depth is that of the free arc",
            "    deep = approach.b * ratio\n",
            "    deep = approach.b\n",
            _T_IMPACT + "test_depth_with_few_nodes_is_no_worse_than_speed[8]",
        ),
        (
            "impact: what the nodes miss is left out",
            "ratio, time = 1.0 + (sum_of(sb) + of_b), sum_of(st) + late",
            "ratio, time = 1.0 + sum_of(sb), sum_of(st) + late",
            _T_IMPACT_ERROR + "test_the_estimate_is_never_below_a_third_of_the_error[12-300]",
        ),
        (
            "impact: what solves it feels no load",
            "push = under(ps.load, push - (ps.stiffness * x1 + ps.damping * (v + damper.share * s)))",
            "push = push - (ps.stiffness * x1 + ps.damping * (v + damper.share * s))",
            _PLAIN_LOADS + "test_a_short_impact_is_that_of_small_steps[30.0-1e-06]",
        ),
        (
            "impact: the virial need not add up",
            "doubt += abs(sum_of(virial)) / (LASTING * deep * s)",
            "doubt += 0.0",
            _PLAIN_LOADS + "test_an_impact_is_doubted_whose_solution_lacks_a_force",
        ),
        (
            "impact: whatever the nodes find is believed",
            "        if settled and found[4] <= arc.tolerance:",
            "        if settled:",
            _T_IMPACT_ERROR + "test_a_wrong_estimate_is_caught",
        ),
        (
            "impact: one sweep is enough",
            "* shrinks * max(shrinks, BY_TIME) <= tolerance:",
            "* 0.0 <= tolerance:",
            _T_IMPACT_ERROR + "test_error_at_most_the_tolerance[300]",
        ),
    ),
    *of(
        "nlds_vines/kernels/impact/inside.py",
        (
            "inside: backward in time, dashpots take as they do forward",
            "damper.m2, damper.k2, -damper.c2, damper.inv_m1,",
            "damper.m2, damper.k2, damper.c2, damper.inv_m1,",
            _PLAIN_INSIDE + "test_backward_in_time_an_impact_is_an_impact",
        ),
        (
            "inside: the structure's dashpot takes backward in time",
            "ps.stiffness, -ps.damping, ps.force, ps.omega",
            "ps.stiffness, ps.damping, ps.force, ps.omega",
            _PLAIN_INSIDE + "test_backward_in_time_an_impact_is_an_impact",
        ),
        (
            "inside: no peak precedes the release",
            "    return longest if early else 0.0, longest if late else 0.0\n",
            "    return longest if early else 0.0, 0.0\n",
            _PLAIN_INSIDE + "test_the_largest_energies_are_those_of_small_steps",
        ),
        (
            "inside: no peak follows the touch",
            "    return longest if early else 0.0, longest if late else 0.0\n",
            "    return 0.0, longest if late else 0.0\n",
            _PLAIN_INSIDE + "test_the_largest_energies_are_those_of_small_steps",
        ),
        (
            "inside: a peak is sought at the very end alone",
            "        soon = took * min(",
            "        soon = 0.1 * took * min(",
            _PLAIN_INSIDE + "test_the_largest_energies_are_those_of_small_steps",
        ),
        (
            "inside: what one impact adds to a response begins with what was before",
            "row[BEFORE + i], row[i] = row[i], 0.0",
            "row[BEFORE + i] = row[i]",
            _PLAIN_INSIDE + "test_a_response_is_that_of_all_steps",
        ),
        (
            "inside: every impact is looked at anew",
            "        if apart <= SAME * side.arc.settled * scale:",
            "        if apart < 0.0:",
            _PLAIN_INSIDE + "test_a_record_out_of_reach_is_not_looked_for",
        ),
        (
            "inside: every impact is taken for one that is known",
            "        if apart <= SAME * side.arc.settled * scale:",
            "        if apart <= math.inf:",
            _PLAIN_INSIDE + "test_of_an_impact_that_is_known_nothing_is_solved",
        ),
        (
            "inside: an impact is cut where it was cut before",
            "    if not abs(w[at + CUT] - ahead.elapsed) <= ",
            "    if not abs(w[at + CUT] - w[at + CUT]) <= ",
            _PLAIN_INSIDE + "test_the_state_at_any_time[1e-06]",
        ),
        (
            "inside: a state is as the half from release has it, backward in time",
            "    return q, sign * s, x1, sign * v1\n",
            "    return q, s, x1, v1\n",
            _PLAIN_INSIDE + "test_the_state_at_any_time[1e-06]",
        ),
        (
            "inside: variations behind a section are those before it",
            " + (TO if begins else ON)",
            " + TO",
            _T_THROUGH + "test_variations_go_on_behind_a_section[0.2]",
        ),
    ),
    *of(
        "nlds_vines/kernels/events/fixed_step.py",
        (
            "fixed_step: the middle of a step has the phase of its start",
            "middle[j] = cos_sin_of_turn(turned(begun, (j + 0.5) / n))[0]",
            "middle[j] = cos_sin_of_turn(turned(begun, j / n))[0]",
            _T_EXACT_FACTS + "test_sections_within_a_period",
        ),
        (
            "fixed_step: a step is not cut short at a touch",
            "return length_to_level(step, low, top, sign, wall.gap)",
            "return top",
            _T_ORDER + "test_fixed_steps_have_order_four_across_contacts[ssul-set6-5]",
        ),
        (
            "fixed_step: the last stage of a step has the phase of its middle",
            "c2 = cosine_at(grid, j, x + length)",
            "c2 = cosine_at(grid, j, x + 0.5 * length)",
            _T_ORDER + "test_fixed_steps_have_order_four_across_contacts[ssul-set6-5]",
        ),
        (
            "fixed_step: a start on the wall that moves in is no touch",
            "    if inside and sign * y[3] > 0.0:\n        return 0.0\n",
            "",
            _PLAIN_METHODS + "test_starts_at_a_wall",
        ),
        (
            "fixed_step: a touch between the ends of a step is not looked for",
            "        if not (sign * y[3] > 0.0 and sign * z[3] < 0.0):\n            return -1.0\n        top",
            "        if sign * y[3] <= 2.0 * abs(y[3]):\n            return -1.0\n        top",
            _PLAIN_METHODS + "test_a_touch_may_be_by_a_hair",
        ),
        (
            "fixed_step: a touch between the ends of a step is not suspected",
            "return beyond or (sign * y[3] > 0.0 and sign * z[3] < 0.0)",
            "return beyond",
            _PLAIN_METHODS + "test_a_touch_may_be_by_a_hair",
        ),
        (
            "fixed_step: the near miss of the far wall has the wrong sign",
            "clearance[0] = min(clearance[0], far.gap + r)",
            "clearance[0] = min(clearance[0], far.gap - r)",
            _PLAIN_METHODS + "test_both_methods_note_the_same[ssbl]",
        ),
        (
            "fixed_step: a near miss is that of the step's end",
            "        r = within(step, top)[2]\n        if near is not None and y[3]",
            "        r = step.z[2]\n        if near is not None and y[3]",
            _PLAIN_METHODS + "test_both_methods_note_the_same[ssul]",
        ),
        (
            "fixed_step: energies and the limit are watched at the starts of steps alone",
            "watch_piece(ps, damper, watch, grid, (c, d), j + x, length)",
            "watch_piece(ps, damper, watch, grid, (c, d), j + x, 0.0)",
            _PLAIN_METHODS + "test_an_excursion_beyond_a_limit_may_be_short",
            _PLAIN_METHODS + "test_both_methods_note_the_same[tmd]",
        ),
    ),
)
