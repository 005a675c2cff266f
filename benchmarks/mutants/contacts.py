"""Mutants of `kernels`: contacts, short impacts and Runge-Kutta steps."""

from __future__ import annotations

from benchmarks.mutants.mutant import Mutant

_FIELD = "nlds_vines/kernels/contact_field.py"
_CONTACT = "nlds_vines/kernels/contact.py"
_IMPACT = "nlds_vines/kernels/impact.py"
_RUNGE_KUTTA = "nlds_vines/kernels/runge_kutta.py"
_FIXED = "nlds_vines/kernels/fixed_step.py"
_T_ORDER = "tests/reference/test_order.py::"
_T_FACTS = "tests/reference/test_exact_facts.py::"
_T_VARIATIONS = "tests/kernels/test_variations.py::"

MUTANTS = (
    Mutant(
        "contact field: variations see no stiffness of the contact",
        _FIELD,
        "stiffness = 1.5 * wall.K * q",
        "stiffness = 1.0 * wall.K * q",
        (_T_VARIATIONS + "test_monodromy_is_the_derivative_of_the_flow[two walls-exact]",),
    ),
    Mutant(
        "contact field: the phase stands still in a step",
        _FIELD,
        "drive = c * cosine - d * sine",
        "drive = c * cosine",
        (_T_ORDER + "test_stepped_contact_has_order_eight",),
    ),
    Mutant(
        "runge_kutta: a coefficient of order eight is off by 1e-6",
        _RUNGE_KUTTA,
        "A12_11 = 0.6433927460157636",
        "A12_11 = 0.6433937460157636",
        (_T_ORDER + "test_stepped_contact_has_order_eight",),
    ),
    Mutant(
        "runge_kutta: the classical step weighs its middle once",
        _RUNGE_KUTTA,
        "(k[K1 + i] + 2.0 * (k[K2 + i] + k[K3 + i]) + k[K4 + i])",
        "(k[K1 + i] + 2.0 * (k[K2 + i] + k[K2 + i]) + k[K4 + i])",
        (_T_ORDER + "test_the_contact_of_rk4_has_order_four",),
    ),
    Mutant(
        "impact: the common motion feels no force",
        _IMPACT,
        "w[FH + i] = alone * (1.0 - damper.share) * dt",
        "w[FH + i] = 0.0 * dt",
        (_T_ORDER + "test_short_impact_converges_geometrically_to_the_stepped_contact",),
    ),
    Mutant(
        "impact: the depth is that of the free arc",
        _IMPACT,
        "deep = b + integral(arc, int(MIDDLE), int(FB))",
        "deep = b",
        (_T_ORDER + "test_short_impact_converges_geometrically_to_the_stepped_contact",),
    ),
    Mutant(
        "fixed_step: the middle of a step has the phase of its start",
        _FIXED,
        "middle[j] = math.cos(2.0 * math.pi * (j + 0.5) / n)",
        "middle[j] = math.cos(2.0 * math.pi * j / n)",
        (_T_FACTS + "test_sections_within_a_period",),
    ),
    Mutant(
        "fixed_step: a step is not cut short at a touch",
        _FIXED,
        "return length_to_level(ps, damper, grid, j, x, low, top, sign, wall.gap, y)",
        "return top",
        (_T_ORDER + "test_fixed_steps_have_order_four_across_contacts[ssul-set6-5]",),
    ),
    Mutant(
        "fixed_step: the last stage of a step has the phase of its middle",
        _FIXED,
        "c2 = math.cos(angle * (j + x + length))",
        "c2 = math.cos(angle * (j + x + 0.5 * length))",
        (_T_ORDER + "test_fixed_steps_have_order_four_across_contacts[ssul-set6-5]",),
    ),
)
