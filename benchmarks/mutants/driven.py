"""Mutants: variations that parameters drive."""

from __future__ import annotations

from benchmarks.mutants.mutant import of

_T = "tests/continuation/plain_derivatives.py::"
_EACH = _T + "test_the_derivative_by_each_parameter_is_that_of_differences"

MUTANTS = (
    *of(
        "nlds_vines/kernels/motion/driven.py",
        (
            "driven: walls stand still where parameters move them",
            "tangent.rows[4 * i + 2] -= way * sign * tangent.rates[i, wall_at(sign) + GAP]",
            "tangent.rows[4 * i + 2] -= 0.0 * way * sign * tangent.rates[i, wall_at(sign) + GAP]",
            _EACH + "[restitution-C]",
        ),
        (
            "driven: a flight is as long at every frequency",
            "rates[SLOWER] = -change.omega / ps.omega",
            "rates[SLOWER] = 0.0",
            _EACH + "[restitution-omega]",
        ),
        (
            "driven: gravity does not change",
            "own = sign * (by[FORCING] * drive - by[STIFFNESS] * x1 - by[DAMPING] * v1) + constant * by[LOAD]",
            "own = sign * (by[FORCING] * drive - by[STIFFNESS] * x1 - by[DAMPING] * v1)",
            _EACH + "[sticking-g]",
        ),
        (
            "driven: the reduced mass does not change",
            "d = own - (pulled * damper.inv_mu + pull * by[INV_MU])",
            "d = own - pulled * damper.inv_mu",
            _EACH + "[restitution-m2]",
        ),
        (
            "driven: a stepped contact is where it was",
            "pushed = pushed_term(wall, k, by, at + 1, n) - k[row + STIFF] * by[at + GAP]",
            "pushed = pushed_term(wall, k, by, at + 1, n)",
            _EACH + "[power-C]",
        ),
    ),
    *of(
        "nlds_vines/kernels/laws/restitution.py",
        (
            "driven: rebounds know nothing of the masses",
            "sign * s * (by[SHARE] * both + damper.share * de)",
            "sign * s * (damper.share * de)",
            _EACH + "[restitution-m2]",
        ),
        (
            "driven: the structure takes no notice of e",
            "sign * s * (by[SHARE] * both + damper.share * de)",
            "sign * s * (by[SHARE] * both)",
            _EACH + "[restitution-e]",
        ),
    ),
    *of(
        "nlds_vines/kernels/laws/power.py",
        (
            "driven: a steeper power has no other force",
            "found += by[at + EXPONENT] * product(",
            "found += 0.0 * product(",
            _EACH + "[power-exponent]",
        ),
    ),
    *of(
        "nlds_vines/kernels/laws/linear_contact.py",
        (
            "driven: a spring counts from where its wall was",
            "return sign * (found - constant * wall.kc * by[wall_at(sign) + GAP])",
            "return sign * found",
            _EACH + "[kelvin-voigt-C]",
        ),
        (
            "driven: a dashpot does not change",
            "found = by[at + KC] * (r - constant * wall.gap) + by[at + CC] * s",
            "found = by[at + KC] * (r - constant * wall.gap)",
            _EACH + "[kelvin-voigt-cc]",
        ),
    ),
)
