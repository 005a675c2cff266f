"""Mutants: contact field, impact, Runge-Kutta steps."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T_VARIATIONS = "tests/kernels/test_variations.py::"
_T_THROUGH = "tests/kernels/test_impact_variations.py::"
_T_ORDER = "tests/reference/test_order.py::"
_T_EXACT_FACTS = "tests/reference/test_exact_facts.py::"
_PLAIN_METHODS = "tests/property/plain_methods.py::"

MUTANTS = (
    *of(
        "nlds_vines/kernels/contact_field.py",
        (
            "contact field: variations see no stiffness of the contact",
            "stiffness = 1.5 * wall.K * q",
            "stiffness = 1.0 * wall.K * q",
            _T_VARIATIONS + "test_monodromy_is_the_derivative_of_the_flow[two walls-exact]",
        ),
        (
            "contact field: the phase stands still in a step",
            "drive = c * cosine - d * sine",
            "drive = c * cosine",
            _T_ORDER + "test_stepped_contact_has_order_eight",
        ),
    ),
    *of(
        "nlds_vines/kernels/runge_kutta.py",
        (
            "runge_kutta: a coefficient of order eight is off by 1e-6",
            "A12_11 = 0.6433927460157636",
            "A12_11 = 0.6433937460157636",
            _T_ORDER + "test_stepped_contact_has_order_eight",
        ),
        (
            "runge_kutta: the classical step weighs its middle once",
            "(k[K1 + i] + 2.0 * (k[K2 + i] + k[K3 + i]) + k[K4 + i])",
            "(k[K1 + i] + 2.0 * (k[K2 + i] + k[K2 + i]) + k[K4 + i])",
            _T_ORDER + "test_the_contact_of_rk4_has_order_four",
        ),
    ),
    *of(
        "nlds_vines/kernels/impact_variations.py",
        (
            "impact variations: the structure stands still until the wall is met",
            "    x, speed = x + v1 * late, speed + ds * late",
            "    speed = speed + ds * late",
            _T_THROUGH + "test_variations_err_by_the_tolerance[1e-09]",
        ),
        (
            "impact variations: the common motion does not move its spring",
            "ps.stiffness * (x + w[T + i] * v)",
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
        "nlds_vines/kernels/impact.py",
        (
            "impact: the common motion feels no force",
            "w[FH + i] = alone * (1.0 - damper.share) * dt",
            "w[FH + i] = 0.0 * dt",
            _T_ORDER + "test_short_impact_converges_geometrically_to_the_stepped_contact",
        ),
        (
            "impact: the depth is that of the free arc",
            "deep = amplitude_at_end(ps, damper, wall, half, b, s)",
            "deep = b",
            _T_ORDER + "test_short_impact_converges_geometrically_to_the_stepped_contact",
        ),
    ),
    *of(
        "nlds_vines/kernels/fixed_step.py",
        (
            "fixed_step: the middle of a step has the phase of its start",
            "middle[j] = cos_sin_of_turn((j + 0.5) / n)[0]",
            "middle[j] = cos_sin_of_turn(j / n)[0]",
            _T_EXACT_FACTS + "test_sections_within_a_period",
        ),
        (
            "fixed_step: a step is not cut short at a touch",
            "return length_to_level(ps, damper, grid, j, x, low, top, sign, wall.gap, y)",
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
            "        r = step_to(ps, damper, grid, j, x, top, y)[2]\n        if near is not None and y[3]",
            "        r = z[2]\n        if near is not None and y[3]",
            _PLAIN_METHODS + "test_both_methods_note_the_same[ssul]",
        ),
        (
            "fixed_step: an excursion between the ends of a step is overlooked",
            "    if y[3] > 0.0 > z[3]:",
            "    if y[3] > 0.0 > z[3] and z[2] > level:",
            _PLAIN_METHODS + "test_an_excursion_beyond_a_limit_may_be_short",
        ),
        (
            "fixed_step: the depth beyond a limit is that of its first step",
            "limit_log[EXCESS] = max(limit_log[EXCESS], highest - level)",
            "limit_log[EXCESS] = limit_log[EXCESS] or highest - level",
            _PLAIN_METHODS + "test_both_methods_note_the_same[ssvi-c]",
        ),
        (
            "fixed_step: an excursion never ends",
            "limit_log[BEYOND] = 1.0 if z[2] > level else 0.0",
            "limit_log[BEYOND] = 1.0",
            _PLAIN_METHODS + "test_both_methods_note_the_same[ssvi-c]",
        ),
        (
            "fixed_step: turns of an energy are noted at the ends of steps alone",
            "        if opposite(before[which], after[which]):\n            low",
            "        if False:\n            low",
            _PLAIN_METHODS + "test_both_methods_note_the_same[tmd]",
        ),
    ),
)
