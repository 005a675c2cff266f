"""A linear structure of any number of degrees of freedom, which dampers are attached to: the host.

M x'' + C x' + K x = F(t), from matrices, from modes or from a file; reduced to its lowest modes and
the static response of chosen degrees of freedom; ready-made frames, beams and chains.
"""

from __future__ import annotations

import copy
import math
import os
from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from inspect import signature
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import scipy  # whose modules are loaded when they are first used: systems of one mass need none

from nlds_vines.archives.representation import Outlined, Rows
from nlds_vines.errors import (
    RequestError,
    at,
    by_dof_names,
    check_name,
    choice,
    dof_name,
    number,
    shown,
    string,
    table,
    truth,
    whole,
)
from nlds_vines.model.host_matrices import (
    MOST_DENSE,
    MOST_ENTRIES,
    array_of,
    matrices_of,
    read_arrays,
)
from nlds_vines.model.parameters import DESCRIBED, STRUCTURE_ITSELF
from nlds_vines.model.ratios import from_percentage, refuse_critical

_ROUNDING = {"M": 1e-10, "K": 1e-12, "C": 1e-10}
"""Eigenvalues of M, scaled to a unit diagonal, exceed this; those of K and C exceed minus this."""

_ROUNDED = range(7, 13)
"""Numbers of significant digits of rounded entries: fewer are exact, more have no effect."""

_RIGID = 64 * np.finfo(float).eps
"""A motion with at most this strain energy, over the sum of K_ii phi_i^2, is a rigid one."""

_CORRECTED = 1e-4
"""Modes with an omega^2 below this fraction of the largest one are corrected."""

_SAFE_PIVOT = 1e-13
"""The least pivot of a matrix with a unit diagonal that round-off leaves three digits of."""

_DEPENDENT = 1e-12
"""A static shape adds nothing if the kept modes hold all but this part of its squared norm."""

ENDS = ("clamped-free", "clamped-clamped", "clamped-pinned", "pinned-pinned", "free-free")
"""The ends of a beam, the first at node 0."""


class Host(Outlined):
    """A linear structure M x'' + C x' + K x = F(t); checked when made, not changed afterwards.

    Parameters
    ----------
    M, K : (n, n) array_like, sparse array, DataFrame or path-like
        Mass [kg] and stiffness [N/m]: symmetric, M positive definite, K positive semidefinite.  A
        path is that of a text (.csv, .txt, .dat, .tsv, .asc), of NumPy's .npy or .npz, or of Matrix
        Market's .mtx.
    C : (n, n) array_like, sparse array, DataFrame or path-like, optional
        Damping [N s/m], symmetric and positive semidefinite; by default 0.
    ratio : float, str or sequence of these, optional
        Modal damping ratio in place of C, 0.02 or "2%": one for all modes, or one for each of the
        lowest modes, the last of which holds for all modes above.
    rayleigh : (float, float) or mapping, optional
        Constants a [1/s] and b [s] of the damping C = a M + b K in place of C; or the two damping
        ratios at two frequencies that determine them, {"ratios": (0.02, 0.03), "f": (1.0, 8.0)},
        with f in Hz, or omega in rad/s in its place.
    dofs : sequence of str or int, optional
        Names of the degrees of freedom, or the numbers of their nodes; by default the names of the
        columns of a DataFrame or of a text, otherwise x1, x2 ...
    influence : (n,) array_like, optional
        The displacement of each degree of freedom when the ground moves by 1, by default 1; that of
        a rotation is 0.
    condense : bool, optional
        Whether degrees of freedom without mass are condensed: they follow the others statically, as
        no force acts on them.  By default they are refused.

    Attributes
    ----------
    M, C, K : (n, n) ndarray or sparse array
        The matrices by coordinate, read-only as all arrays of a host.
    dofs : tuple of str
        Names of the degrees of freedom.
    coordinates : tuple of str
        Names of the coordinates: the degrees of freedom, without those that were condensed; mode1,
        mode2 ... of a host that was reduced or made from modes.
    condensed : tuple of str
        Names of the degrees of freedom that were condensed, on which no force or damper can act.
    shape : (len(dofs), n) ndarray
        Displacement of the degrees of freedom by coordinate: the identity, unless the host was
        condensed, reduced or made from modes.
    influence : (len(dofs),) ndarray
        The displacement of each degree of freedom when the ground moves by 1.
    inertia : (n,) ndarray
        Minus the force on each coordinate for a unit acceleration of the ground [kg].
    note : str
        How the host was condensed and reduced; "" if it was not.
    is_plain : bool
        Whether the coordinates are the degrees of freedom.

    Raises
    ------
    RequestError
        For matrices of different sizes, one that is not symmetric or has a forbidden sign, values
        that are not finite, two statements about the damping, and names that are not different.

    See Also
    --------
    shear_frame, beam, chain

    Examples
    --------
    >>> import nlds_vines as nv
    >>> host = nv.Host(M=[[2.0, 0.0], [0.0, 1.0]], K=[[30.0, -10.0], [-10.0, 10.0]], ratio=0.01)
    >>> host.frequencies.round(3)
    array([2.236, 4.472])
    """

    def __init__(
        self,
        M: Any,
        K: Any,
        C: Any = None,
        *,
        ratio: Any = None,
        rayleigh: Any = None,
        dofs: Sequence[str | int] = (),
        influence: Any = None,
        condense: bool = False,
    ) -> None:
        if sum(value is not None for value in (C, ratio, rayleigh)) > 1:
            raise RequestError("the damping is stated twice; allowed: one of C, ratio, rayleigh")
        sources = {"M": M, "K": K} if C is None else {"M": M, "K": K, "C": C}
        matrices, labels = matrices_of(sources)
        self.M = matrices["M"]
        self.K = matrices["K"]
        self.C = matrices.get("C")
        n = self.M.shape[0]
        for name, matrix in matrices.items():
            if matrix.shape != (n, n):
                raise RequestError(f"{name} has the shape {matrix.shape}, but M has {(n, n)}")
        self.dofs = _names(_sequence("dofs", dofs) or labels, n)
        is_dense = not scipy.sparse.issparse(self.M)
        self.shape = np.eye(n) if is_dense else scipy.sparse.eye_array(n, format="csr")
        moved = np.ones(n) if influence is None else _vector("influence", influence)
        if moved.shape != (n,):
            raise RequestError(f"influence has {moved.size} values for {n} degrees of freedom")
        self.coordinates = self.dofs
        self.condensed: tuple[str, ...] = ()
        self.note = ""
        self.is_plain = True
        self.source: Source | None = None
        self.factors: Mapping[str, float] = MappingProxyType({})
        self._unscaled: Host | None = None
        self._shake(moved)
        self.ratio = None if ratio is None else _ratios("ratio", ratio)
        errors = {name: _rounding(matrix) * abs(matrix) for name, matrix in matrices.items()}
        if rayleigh is not None:
            a, b = _rayleigh(rayleigh)
            with np.errstate(over="ignore"):
                self.C = a * self.M + b * self.K
                errors["C"] = a * errors["M"] + b * errors["K"]
            entries = self.C.data if scipy.sparse.issparse(self.C) else self.C
            if not np.isfinite(entries).all():
                raise RequestError("rayleigh gives a damping that is no finite number")
        if truth("condense", condense):
            errors = self._condense(errors)
        self._refuse_signs(errors)
        if not scipy.sparse.issparse(self.M):
            self._complete()

    def __setattr__(self, name: str, value: Any) -> None:
        """Make arrays read-only: frequencies would not follow a changed entry."""
        array = value.data if scipy.sparse.issparse(value) else value
        if isinstance(array, np.ndarray):
            array.setflags(write=False)
        super().__setattr__(name, value)

    def _shake(self, influence: np.ndarray) -> None:
        """Set the displacement of each degree of freedom when the ground moves by 1."""
        self.influence = influence
        places = [self.dofs.index(name) for name in self.condensed]
        moved = np.delete(influence, places)
        with np.errstate(over="ignore", invalid="ignore"):
            if scipy.sparse.issparse(self.M):
                inertia = self.M @ moved
            else:  # sums of dense rows are rounded once: the same bits on every processor
                products = self.M * moved
                is_finite = np.isfinite(products).all()
                inertia = np.array([math.fsum(row) for row in products] if is_finite else [np.inf])
        if not np.isfinite(inertia).all():
            raise RequestError("M times the influence is no finite number: check the units")
        self.inertia = inertia

    def _condense(self, errors: dict[str, Any]) -> dict[str, Any]:
        """Let the degrees of freedom without mass, c, follow the others, r, statically.

        Returns bounds of the errors of the condensed matrices from those of their entries.

        No force acts on them, so that u_c = -K_cc^-1 K_cr u_r; with u = T u_r, the matrices become
        T^T A T.  This is exact if C has no entry of c, or is proportional to M and K.
        """
        columns = scipy.sparse.csc_array(abs(self.M)).sum(axis=0)
        massless = np.flatnonzero(columns == 0)
        massive = np.flatnonzero(columns)
        if massless.size == 0:
            return errors
        if massive.size == 0:
            raise RequestError("M is 0: no degree of freedom has a mass")
        if massless.size * massive.size > MOST_ENTRIES:
            raise RequestError(
                f"{massless.size} of {len(self.dofs)} degrees of freedom have no mass: too many to "
                "condense"
            )
        T = np.zeros((len(self.dofs), massive.size))
        T[massive, np.arange(massive.size)] = 1.0
        T[massless] = -_solved(
            self.K[np.ix_(massless, massless)], self.K[np.ix_(massless, massive)]
        )
        for name in ("M", "K", "C"):
            matrix = getattr(self, name)
            if matrix is not None:
                product = T.T @ (matrix @ T)
                symmetric = (product + product.T) / 2
                is_dense = massive.size <= MOST_DENSE
                setattr(self, name, symmetric if is_dense else scipy.sparse.csc_array(symmetric))
        self.condensed = tuple(self.dofs[i] for i in massless)
        self.coordinates = tuple(self.dofs[i] for i in massive)
        self.shape = T
        self.is_plain = False
        plural = "s" if massless.size > 1 else ""
        self.note = f"{massless.size} degree{plural} of freedom without mass condensed"
        self._shake(self.influence)
        return {name: abs(T).T @ (bound @ abs(T)) for name, bound in errors.items()}

    def _refuse_signs(self, errors: Mapping[str, Any]) -> None:
        """Refuse a mass that is not positive, and a negative stiffness or damping.

        errors: bounds of the errors of entries.  Rounding entries to few digits moves an eigenvalue
        by at most the norm of these bounds, hence by the largest sum of a row: a motion without
        stiffness may have a negative one of this size, and is no instability.
        """
        for name, mass in zip(self.coordinates, self.M.diagonal(), strict=True):
            if mass <= 0:
                raise RequestError(
                    f"M gives the degree of freedom {name!r} the mass {mass:g}, which must be > 0: "
                    "add its mass, or take condense=True, by which it follows the others statically"
                )
        for name in ("M", "K", "C"):
            matrix = getattr(self, name)
            if matrix is not None:
                is_mass = name == "M"
                scaled, scale = _with_unit_diagonal(matrix)
                least = _ROUNDING[name]
                if not is_mass:
                    rounding = (scale * (errors[name] @ scale)).max()
                    least = -max(least, float(rounding))
                failure = _below(least, scaled)
                if failure:
                    kind = "positive definite" if is_mass else "positive semidefinite"
                    raise RequestError(
                        f"{name} must be {kind}, but has {failure} (scaled to a unit diagonal)"
                    )

    def _complete(self) -> None:
        """Compute all modes, and from them the damping matrix of modal ratios."""
        with np.errstate(all="ignore"):  # what is not finite is refused below
            try:
                self._squares, self._vectors = _modes(self.K, self.M, len(self.inertia))
            except np.linalg.LinAlgError as error:
                raise RequestError(f"M and K give no modes: {error}") from None
            if self.ratio is not None:
                moments = self.M @ self._vectors
                self.C = (moments * modal_damping(self.ratio, self._squares)) @ moments.T
            elif self.C is None:
                self.C = np.zeros_like(self.K)
        for what, values in (
            ("M and K give a frequency", self._squares),
            ("M and K give a mode", self._vectors),
            ("the damping gives a value", self.C),
        ):
            if not np.isfinite(values).all():
                raise RequestError(f"{what} that is no finite number: check the units")

    def _in_modes(
        self,
        dofs: Sequence[str],
        shape: np.ndarray,
        inertia: np.ndarray,
        moved: np.ndarray,
        note: str = "",
        condensed: Sequence[str] = (),
    ) -> Host:
        """Make the coordinates those of modes, from which `shape` leads to degrees of freedom."""
        sizes, count = (*shape.shape, len(inertia), len(moved)), len(self.K)
        if sizes != (len(shape), count, count, len(shape)):
            raise RequestError(
                f"shape {shape.shape}, inertia ({len(inertia)}) and influence ({len(moved)}) do "
                f"not fit {count} modes"
            )
        self.dofs, self.shape, self.inertia = _names(dofs, len(shape)), shape, inertia
        self.coordinates = tuple(f"mode{i + 1}" for i in range(count))
        self.condensed = tuple(choice("condensed", name, self.dofs) for name in condensed)
        self.influence, self.note, self.is_plain = moved, note, False
        return self

    @classmethod
    def from_modes(cls, modes: Sequence[Mapping[str, Any]], *, dofs: Sequence[str] = ()) -> Host:
        """Return the host with given modes, measured or from another program.

        Parameters
        ----------
        modes : sequence of mapping
            For each mode its frequency `f` [Hz], its damping ratio `zeta` (by default 0), and its
            `shape`, a mapping from names of degrees of freedom to displacements, normalized to a
            modal mass of 1 kg; a degree of freedom that is left out does not move.  For motion of
            the ground also `participation`, the sum of mass times displacement over the structure
            [kg^0.5], by default 0.
        dofs : sequence of str, optional
            The order of the degrees of freedom, by default that of their first mention.

        Returns
        -------
        Host
            Its coordinates are the modes' amplitudes.

        Raises
        ------
        RequestError
            For an empty list, an unknown key, and a frequency that is not > 0.

        Examples
        --------
        >>> import nlds_vines as nv
        >>> modes = [{"f": 4.1, "zeta": 0.01, "shape": {"tip": 2.0, "middle": 0.7}}]
        >>> nv.Host.from_modes(modes).dofs
        ('tip', 'middle')
        """
        if not _sequence("modes", modes):
            raise RequestError("modes = [] has no mode; give at least one")
        names = dict.fromkeys(check_name("dofs", name) for name in _sequence("dofs", dofs))
        rows = []
        for i, mode in enumerate(modes):
            with at(f"mode {i + 1}"):
                row = table("mode", mode, ("f", "zeta", "shape", "participation"))
                names |= dict.fromkeys(table("shape", row.get("shape")))
                f = number("f", row.get("f"))
                if f <= 0:
                    raise RequestError(f"f = {f:g} must be > 0 [Hz]")
                values = {key: number(key, value) for key, value in row["shape"].items()}
                (zeta,) = _ratios("zeta", [row.get("zeta", 0.0)])
                rows.append((2 * np.pi * f, zeta, values, row.get("participation", 0.0)))
        rows.sort(key=lambda row: row[0])
        rates = np.array([row[0] for row in rows])
        host = cls(np.eye(len(rows)), np.diag(rates**2), ratio=[row[1] for row in rows])
        shape = np.array([[row[2].get(name, 0.0) for row in rows] for name in names])
        inertia = np.array([number("participation", row[3]) for row in rows])
        return host._in_modes(tuple(names), shape, inertia, np.ones(len(names)))

    @classmethod
    def from_file(
        cls, path: str | os.PathLike[str], *others: str | os.PathLike[str], **options: Any
    ) -> Host:
        """Return the host whose matrices stand in one file of NumPy, or in one file each.

        Parameters
        ----------
        path : str or path-like
            A `.npz` file with the arrays M and K (m and k, mass and stiffness), and, if it has
            them, C (c, damping), influence and dofs.  Other arrays are ignored.
        *others : str or path-like
            If `path` has M alone, the file of K, and that of C if there is one: texts, .npy, .npz
            or .mtx, as `Host` takes them.
        **options
            `ratio`, `rayleigh`, `dofs`, `influence` and `condense`, as `Host` takes them; they
            override what the file says.

        Returns
        -------
        Host
            The host.

        Raises
        ------
        RequestError
            For a file that cannot be read or lacks M or K, and as `Host`.

        Examples
        --------
        >>> import numpy as np
        >>> import nlds_vines as nv
        >>> np.savez("frame.npz", M=np.eye(2), K=[[2.0, -1.0], [-1.0, 1.0]], dofs=["floor", "roof"])
        >>> nv.Host.from_file("frame.npz", ratio=0.02).dofs
        ('floor', 'roof')
        >>> np.savetxt("M.txt", np.eye(2))
        >>> np.savetxt("K.txt", [[2.0, -1.0], [-1.0, 1.0]])
        >>> nv.Host.from_file("M.txt", "K.txt").dofs
        ('x1', 'x2')
        """
        for one in (path, *others):
            if not isinstance(one, str | os.PathLike):
                raise RequestError(f"path = {shown(one)} must be a path")
        if len(others) > 2:
            raise RequestError(f"{1 + len(others)} files; allowed: those of M, K and C")
        if others:
            return cls(Path(path), *map(Path, others), **options)
        with at(str(path)):
            arrays = read_arrays(Path(path))
            if options.keys() & {"ratio", "rayleigh"}:
                arrays.pop("C", None)
            return cls(**{**arrays, **options})

    def heading(self) -> str:
        """Return the number of degrees of freedom, and how they were reduced."""
        return f"{len(self.dofs)} degrees of freedom{self.note and ', '}{self.note}"

    def outline(self) -> Rows:
        """Return the names, the lowest frequencies in Hz and their damping ratios."""
        yield "dofs", ", ".join(self.dofs[:8]) + ", ..." * (len(self.dofs) > 8)
        if self.condensed:
            names = ", ".join(self.condensed[:8]) + ", ..." * (len(self.condensed) > 8)
            yield "condensed", f"{names}: without mass, they follow the others statically"
        if not scipy.sparse.issparse(self.M):
            values = self.frequencies[:6] / (2 * np.pi)
            yield "frequencies [Hz]", ", ".join(f"{value:.4g}" for value in values)
            yield "damping ratios", ", ".join(f"{value:.3g}" for value in self.damping_ratios[:6])

    @property
    def frequencies(self) -> np.ndarray:
        """Frequencies of the undamped modes [rad/s], ascending; 0 of a motion without stiffness."""
        self._refuse_large()
        return np.sqrt(self._squares)

    @property
    def modes(self) -> np.ndarray:
        """Shapes of the undamped modes [kg^-0.5], (len(dofs), n), with a modal mass of 1 kg."""
        self._refuse_large()
        return self.shape @ self._vectors

    @property
    def damping_ratios(self) -> np.ndarray:
        """Damping ratio of each mode, c / (2 omega) of its diagonal term; NaN where omega = 0."""
        self._refuse_large()
        rates = np.sum(self._vectors * (self.C @ self._vectors), axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(self._squares > 0, rates / (2 * self.frequencies), np.nan)

    @property
    def places(self) -> tuple[str, ...]:
        """The degrees of freedom that forces and dampers may act on: those not condensed."""
        return tuple(name for name in self.dofs if name not in self.condensed)

    def row(self, dof: str | int) -> np.ndarray:
        """Return the displacement of a degree of freedom by coordinate, (n,).

        Parameters
        ----------
        dof : str or int
            Its name, or the number of its node.

        Returns
        -------
        (n,) ndarray
            Its row of `shape`.

        Raises
        ------
        RequestError
            For a name that the host does not have.
        """
        name = dof_name("degree of freedom", dof)
        index = self.dofs.index(choice("degree of freedom", name, self.dofs))
        unit = np.zeros(len(self.dofs))
        unit[index] = 1.0
        return self.shape.T @ unit

    def reduced(
        self,
        keep: int | None = None,
        *,
        below: float | None = None,
        statics: Sequence[str | int] = (),
    ) -> Host:
        """Return the host reduced to its lowest modes and to chosen static responses.

        The response of the modes that are left out to a slow force is their static one.  It is kept
        for forces on the degrees of freedom in `statics`, where dampers and forces will act, by one
        more coordinate each: the residual flexibility.

        Parameters
        ----------
        keep : int, optional
            The number of modes.
        below : float, optional
            In its place, the frequency [rad/s] up to which modes are kept.
        statics : sequence of str or int, optional
            Names of degrees of freedom.

        Returns
        -------
        Host
            A host with the same degrees of freedom; its coordinates are modal.

        Raises
        ------
        RequestError
            If not exactly one of `keep` and `below` is given, if no mode is left, and for an
            unknown degree of freedom.

        Notes
        -----
        With the kept modes Phi and e_a, the unit force on a, the further shape is
        K^-1 (e_a - M Phi Phi^T e_a); the modes of the host within the span of all shapes are the
        coordinates.

        References
        ----------
        MacNeal, Comput. Struct. 1 (1971) 581-601, doi 10.1016/0045-7949(71)90031-9.

        Examples
        --------
        >>> import nlds_vines as nv
        >>> frame = nv.shear_frame([1e4] * 10, [8e6] * 10, ratio=0.02)
        >>> frame.reduced(3, statics=["roof"]).heading()
        '10 degrees of freedom, 3 of 10 modes and the static response of roof'
        """
        n = len(self.inertia)
        if (keep is None) == (below is None):
            raise RequestError("a reduction needs one of keep and below")
        if below is not None:
            limit = number("below", below)
            self._refuse_large("below; give keep")
            keep = int(np.sum(self.frequencies <= limit))
            if keep == 0:
                lowest = f"{self.frequencies[0]:.4g} rad/s"
                raise RequestError(f"below = {limit:g} leaves no mode: the lowest has {lowest}")
        places = [dof_name("statics", label) for label in _sequence("statics", statics)]
        most = n if n <= MOST_DENSE else MOST_DENSE - len(places)
        count = whole("keep", keep, 1, most)
        squares, vectors = (
            _modes(self.K, self.M, count)
            if scipy.sparse.issparse(self.M)
            else (self._squares[:count], self._vectors[:, :count])
        )
        basis = [vectors]
        if places and count < n:
            # K may be singular: the load has no part in the kept modes, a small mass changes little
            stiffness = self.K + 1e-8 * (squares[-1] or 1.0) * self.M
            for dof in places:
                row = self.row(dof)
                load = row - self.M @ (vectors @ (vectors.T @ row))
                if scipy.sparse.issparse(stiffness):
                    from scipy.sparse.linalg import spsolve

                    shape = spsolve(stiffness.tocsc(), load)
                else:
                    shape = scipy.linalg.solve(stiffness, load, assume_a="pos")
                norm = np.sqrt(shape @ (self.M @ shape))
                for other in (*basis, *basis):  # twice: what one projection leaves is rounding
                    shape = shape - other @ (other.T @ (self.M @ shape))
                remainder = np.sqrt(shape @ (self.M @ shape))
                if remainder > np.sqrt(_DEPENDENT) * norm:
                    basis.append(shape[:, None] / remainder)
        V = vectors
        if len(basis) > 1:
            # K couples no mode with what is left of the static shapes: their modes stand beside
            span = np.hstack(basis[1:])
            static_squares, turned = _modes(
                span.T @ (self.K @ span), span.T @ (self.M @ span), span.shape[1]
            )
            squares = np.append(squares, static_squares)
            V = np.hstack([vectors, span @ turned])
        C = None if self.C is None or self.ratio is not None else V.T @ (self.C @ V)
        host = Host(np.eye(V.shape[1]), np.diag(squares), C, ratio=self.ratio)
        names = ", ".join(places)
        note = f"{count} of {n} modes" + (names and f" and the static response of {names}")
        note = f"{self.note}, {note}" if self.condensed else note
        inertia = V.T @ self.inertia
        return host._in_modes(
            self.dofs, self.shape @ V, inertia, self.influence, note, self.condensed
        )

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers that `with_numbers` replaces, by name, but factors of 1.

        `floor2.m` and `floor2.k` of a shear frame or a chain; `host.ratio` if all modes have the
        same damping ratio; `host.M`, `host.K`, `host.C`, factors on its matrices.
        """
        values: dict[str, float] = {}
        if self.source is not None:
            values |= self.source.numbers
        if self._one_ratio is not None:
            values[f"{STRUCTURE_ITSELF}.ratio"] = self._one_ratio
        for key, factor in self.factors.items():
            values[f"{STRUCTURE_ITSELF}.{key}"] = factor
        return values

    @property
    def _one_ratio(self) -> float | None:
        ratio = (self._unscaled or self).ratio
        return float(ratio[0]) if ratio is not None and len(ratio) == 1 else None

    @property
    def settable(self) -> tuple[str, ...]:
        """The names of all numbers that `with_numbers` replaces."""
        return tuple(dict.fromkeys([*self.numbers, *self.unstated]))

    @property
    def unstated(self) -> dict[str, float]:
        """The numbers that `with_numbers` replaces beside `numbers`, by name.

        Factors of 1, and the damping ratio 0 of a host without damping.
        """
        bare = self._unscaled or self
        values = {f"{STRUCTURE_ITSELF}.{key}": 1.0 for key in ("M", "K", "C")}
        if bare.ratio is None and (bare.C is None or abs(bare.C).max() == 0.0):
            values[f"{STRUCTURE_ITSELF}.ratio"] = 0.0
        numbers = self.numbers
        return {name: value for name, value in values.items() if name not in numbers}

    def with_numbers(self, values: Mapping[str, float]) -> Host:
        """Return the host with other numbers, named as in `settable`; they are not checked."""
        return _with_numbers(self, tuple(values.items()))

    def _made_again(self, values: Mapping[str, float]) -> Host:
        """Return the host before factors with other numbers of its source, or another ratio."""
        ratio = values.get(f"{STRUCTURE_ITSELF}.ratio")
        host = copy.copy(self)
        if self.source is not None:
            host.source = self.source.changed(values, ratio)
            if not host.source.arguments.keys().isdisjoint(("rayleigh", "condense")):
                return host.source.made()
            host.M, host.K = host.source.matrices()
            host._shake(host.influence)
        if ratio is not None:
            host.ratio = np.array([ratio])
        host._complete()
        return host

    def _scaled(self, factors: Mapping[str, float]) -> Host:
        """Return the host with factors on its matrices; a damping ratio is scaled as C is."""
        host = copy.copy(self)
        host.factors = MappingProxyType(dict(factors))
        host._unscaled = self
        host.M = self.M * factors.get("M", 1.0)
        host.inertia = self.inertia * factors.get("M", 1.0)
        host.K = self.K * factors.get("K", 1.0)
        damping = factors.get("C", 1.0)
        if self.ratio is not None:
            host.ratio = self.ratio * damping
        elif self.C is not None:
            host.C = self.C * damping
        if not scipy.sparse.issparse(host.M):
            host._complete()
        return host

    def frequency_response(
        self, omega: Any, *, force: Mapping[str, float] | None = None, base: float | None = None
    ) -> np.ndarray:
        """Return the steady response to a harmonic force, or to harmonic motion of the ground.

        Parameters
        ----------
        omega : array_like
            Frequencies [rad/s].
        force : mapping of str to float, optional
            Amplitudes P [N] of the forces P cos(omega t) by degree of freedom.
        base : float, optional
            In its place, the amplitude of the acceleration of the ground [m/s^2]; the response is
            relative to the ground.

        Returns
        -------
        (..., len(dofs)) ndarray of complex
            X [m] of x = Re(X exp(i omega t)), in the shape of `omega`; infinite at a resonance
            without damping.

        Raises
        ------
        RequestError
            If not exactly one of `force` and `base` is given, and for an unknown degree of freedom.

        Examples
        --------
        >>> import nlds_vines as nv
        >>> frame = nv.shear_frame([1e4] * 3, [8e6] * 3, ratio=0.02)
        >>> X = frame.frequency_response(frame.frequencies[0], force={"roof": 1e3})
        >>> abs(X).round(4)
        array([0.0038, 0.0069, 0.0086])
        """
        self._refuse_large()
        if (force is None) == (base is None):
            raise RequestError("a response needs one of force and base")
        if base is not None:
            load = -number("base", base) * self.inertia
        else:
            amplitudes = table("force", by_dof_names("force", force), self.places)
            load = sum(
                (number(f"force.{dof}", P) * self.row(dof) for dof, P in amplitudes.items()),
                np.zeros(len(self.inertia)),
            )
        frequencies = _vector("omega", np.ravel(omega))
        result = np.empty((frequencies.size, len(self.dofs)), dtype=complex)
        for i, rate in enumerate(frequencies):
            impedance = self.K - rate**2 * self.M + 1j * rate * self.C
            try:
                result[i] = self.shape @ np.linalg.solve(impedance, load)
            except np.linalg.LinAlgError:
                result[i] = np.inf
        return result.reshape(*np.shape(omega), len(self.dofs))

    def _refuse_large(self, what: str = "all its modes") -> None:
        if scipy.sparse.issparse(self.M):
            raise RequestError(
                f"a host of {len(self.inertia)} coordinates is too large for {what}: reduce it "
                "first, host.reduced(keep=20, statics=[...])"
            )


@lru_cache(maxsize=64)
def _with_numbers(host: Host, values: tuple[tuple[str, float], ...]) -> Host:
    bare = host._unscaled or host
    factors = dict(host.factors)
    others = {}
    for name, value in values:
        owner, _, key = name.partition(".")
        if owner == STRUCTURE_ITSELF and key in ("M", "K", "C"):
            factors[key] = value
        else:
            others[name] = value
    if others:
        bare = bare._made_again(others)
    return bare._scaled(factors) if factors else bare


class Source(NamedTuple):
    """The masses and springs that a shear frame or a chain is made of.

    Attributes:
        maker: "shear_frame" or "chain".
        masses, springs: by degree of freedom; a chain may have one more spring, to the ground.
        dofs: the degrees of freedom.
        arguments: other arguments of the maker.
    """

    maker: str
    masses: tuple[float, ...]
    springs: tuple[float, ...]
    dofs: tuple[str, ...]
    arguments: Mapping[str, Any]

    @property
    def numbers(self) -> dict[str, float]:
        """The masses `floor2.m` and the stiffnesses `floor2.k` of the springs below, by name."""
        by_name = {f"{dof}.m": m for dof, m in zip(self.dofs, self.masses, strict=True)}
        return by_name | {f"{dof}.k": k for dof, k in zip(self.dofs, self.springs, strict=False)}

    def changed(self, values: Mapping[str, float], ratio: float | None = None) -> Source:
        """Return the source with other numbers by name, and with another damping ratio."""
        masses = [values.get(f"{dof}.m", m) for dof, m in zip(self.dofs, self.masses, strict=True)]
        springs = list(self.springs)
        for i, dof in enumerate(self.dofs):
            springs[i] = values.get(f"{dof}.k", springs[i])
        arguments = dict(self.arguments)
        if ratio is not None:
            arguments["ratio"] = ratio
        return self._replace(masses=tuple(masses), springs=tuple(springs), arguments=arguments)

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the mass and the stiffness matrix."""
        held = _repeated(self.arguments.get("grounds", 0.0), len(self.masses))
        springs = np.array(self.springs)
        is_cyclic = bool(self.arguments.get("cyclic", False))
        K = _stiffness_of_chain(springs, _vector("grounds", held), is_cyclic)
        return np.diag(np.array(self.masses)), K

    def to_table(self) -> dict[str, Any]:
        """Return the table of a request file that makes the host."""
        springs = "springs" if self.maker == "chain" else "stiffnesses"
        of_maker: dict[str, Any] = {"masses": list(self.masses), springs: list(self.springs)}
        options: dict[str, Any] = {}
        for name, value in self.arguments.items():
            (of_maker if name in ("grounds", "cyclic") else options)[name] = _plain(value)
        return {self.maker: of_maker, **options}

    def made(self) -> Host:
        """Return the host."""
        host: Host = _READY[self.maker](self.masses, self.springs, **self.arguments)
        return host


def shear_frame(masses: Sequence[float], stiffnesses: Sequence[float], **options: Any) -> Host:
    """Return the shear frame of some storeys on the ground.

    Parameters
    ----------
    masses : sequence of float
        Mass [kg] of each floor, from below.
    stiffnesses : sequence of float
        Stiffness [N/m] of each storey against drift, from below.
    **options
        `C`, `ratio`, `rayleigh` and `dofs`, as `Host` takes them.

    Returns
    -------
    Host
        Its degrees of freedom are the floors' displacements, by default floor1, floor2 ... roof.

    Raises
    ------
    RequestError
        For a mass that is not > 0, a negative stiffness, and for different numbers of them.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> frame = nv.shear_frame([1e4, 1e4, 1e4], [8e6, 8e6, 8e6], ratio=0.02)
    >>> frame.dofs, (frame.frequencies / 6.2831853).round(2)
    (('floor1', 'floor2', 'roof'), array([2.  , 5.61, 8.11]))
    """
    m, k = _vector("masses", masses), _vector("stiffnesses", stiffnesses, least=0.0)
    if m.size != k.size:
        raise RequestError(f"{k.size} stiffnesses do not fit {m.size} masses")
    floors = [f"floor{i + 1}" for i in range(m.size - 1)]
    options = {"dofs": [*floors, "roof"], **options}
    frame = chain(masses, stiffnesses, **options)
    frame.source = Source("shear_frame", tuple(m.tolist()), tuple(k.tolist()), frame.dofs, options)
    return frame


def chain(
    masses: Sequence[float],
    springs: Sequence[float],
    *,
    grounds: float | Sequence[float] = 0.0,
    cyclic: bool = False,
    **options: Any,
) -> Host:
    """Return a chain of masses, open or cyclic, with springs between neighbors and to the ground.

    Parameters
    ----------
    masses : sequence of float
        The n masses [kg].
    springs : sequence of float
        Their n stiffnesses [N/m]: the first spring holds the first mass to the ground, each other
        one couples a mass to the one before.  Of n + 1 the last holds the last mass to the ground.
    grounds : float or sequence of float, optional
        Stiffness [N/m] of a spring from each mass to the ground.
    cyclic : bool, optional
        The first of n springs couples the first mass to the last one, not to the ground.
    **options
        `C`, `ratio`, `rayleigh` and `dofs`, as `Host` takes them.

    Returns
    -------
    Host
        Its degrees of freedom are the masses' displacements, by default x1, x2 ...

    Raises
    ------
    RequestError
        For a mass that is not > 0, a negative stiffness, and a number of springs that does not fit.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> nv.chain([1.0] * 4, [0.5] * 4, grounds=1.0, cyclic=True).frequencies.round(4)
    array([1.    , 1.4142, 1.4142, 1.7321])
    """
    m, k = _vector("masses", masses), _vector("springs", springs, least=0.0)
    n = m.size
    truth("cyclic", cyclic)
    held = _vector("grounds", _repeated(grounds, n), least=0.0)
    if held.size != n:
        raise RequestError(f"{held.size} grounds do not fit {n} masses")
    if k.size not in ((n,) if cyclic else (n, n + 1)):
        raise RequestError(f"{k.size} springs do not fit {n} masses")
    host = Host(np.diag(m), _stiffness_of_chain(k, held, cyclic), **options)
    arguments = {"grounds": grounds, "cyclic": cyclic, **options}
    host.source = Source("chain", tuple(m.tolist()), tuple(k.tolist()), host.dofs, arguments)
    return host


def _stiffness_of_chain(k: np.ndarray, held: np.ndarray, cyclic: bool) -> np.ndarray:
    n = held.size
    left = np.append(k, np.zeros(n + 1 - k.size))
    if cyclic:
        left[n] = k[0]
    K = np.diag(left[:n] + left[1:] + held)
    for i in range(0 if cyclic else 1, n):
        K[i, i - 1] -= k[i]
        K[i - 1, i] -= k[i]
    return K


def beam(
    length: float,
    bending_stiffness: float,
    mass_per_length: float,
    *,
    ends: str = "clamped-free",
    elements: int = 20,
    **options: Any,
) -> Host:
    """Return a slender uniform beam (Euler and Bernoulli) in bending.

    Parameters
    ----------
    length : float
        Length [m].
    bending_stiffness : float
        Bending stiffness E I [N m^2].
    mass_per_length : float
        Mass per length, rho A [kg/m].
    ends : str, optional
        "clamped-free", "clamped-clamped", "clamped-pinned", "pinned-pinned" or "free-free".
    elements : int, optional
        Number of elements of equal length; the frequency of mode j of n elements errs by about
        (j / n)^4.
    **options
        `C`, `ratio` and `rayleigh`, as `Host` takes them.

    Returns
    -------
    Host
        Its degrees of freedom are the deflections w0, w1 ... and rotations theta0, theta1 ... of
        the nodes that its ends leave free; the ground moves across the beam.

    Raises
    ------
    RequestError
        For a value that is not > 0, and for unknown ends.

    Examples
    --------
    >>> import nlds_vines as nv
    >>> cantilever = nv.beam(1.0, 65.6, 1.18, ratio=0.01)  # a strip of steel, 30 mm by 5 mm
    >>> (cantilever.frequencies[:3] / 6.2831853).round(2)
    array([ 4.17, 26.15, 73.22])
    """
    values = {"length": length, "bending_stiffness": bending_stiffness}
    values["mass_per_length"] = mass_per_length
    for name, value in values.items():
        if number(name, value) <= 0:
            raise RequestError(f"{name} = {value:g} must be > 0")
    choice("ends", ends, ENDS)
    n = whole("elements", elements, 2, MOST_DENSE // 2 - 1)
    h = length / n
    scale = np.array([1.0, h, 1.0, h])  # rotations times h are deflections
    stiffness = [[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]
    mass = [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
    K, M = np.zeros((2, 2 * n + 2, 2 * n + 2))
    for i in range(0, 2 * n, 2):
        K[i : i + 4, i : i + 4] += np.multiply(stiffness, bending_stiffness / h**3)
        M[i : i + 4, i : i + 4] += np.multiply(mass, mass_per_length * h / 420)
    turns = np.tile(scale[:2], n + 1)
    K, M = (A * np.outer(turns, turns) for A in (K, M))
    fixed = {"clamped": (0, 1), "pinned": (0,), "free": ()}
    first, last = ends.split("-")
    gone = [*fixed[first], *(2 * n + i for i in fixed[last])]
    free = np.setdiff1d(np.arange(2 * n + 2), gone)
    names = [f"{name}{i}" for i in range(n + 1) for name in ("w", "theta")]
    return Host(
        M[np.ix_(free, free)],
        K[np.ix_(free, free)],
        dofs=[names[i] for i in free],
        influence=1.0 - free % 2,
        **options,
    )


# ---- the table [system.host] of a request file ---------------------------------------------------

_READY: Mapping[str, Any] = {make.__name__: make for make in (shear_frame, beam, chain)}
_OPTIONS = ("ratio", "rayleigh", "dofs", "influence", "condense")
_REDUCTION = ("keep", "below", "statics")
_FACTORS = "factors"  # on the matrices M, K and C
KEYS = {  # of the table of a host, by the key that says where it comes from
    "file": ("file", *_OPTIONS, *_REDUCTION, _FACTORS),
    "M": ("M", "K", "C", *_OPTIONS, *_REDUCTION, _FACTORS),
    "modes": ("modes", "dofs", *_REDUCTION, _FACTORS),
    "shear_frame": ("shear_frame", "C", *_OPTIONS, *_REDUCTION, _FACTORS),
    "beam": ("beam", "ratio", "rayleigh", *_REDUCTION, _FACTORS),
    "chain": ("chain", "C", *_OPTIONS, *_REDUCTION, _FACTORS),
    "shape": (
        "shape",
        "M",
        "K",
        "C",
        "ratio",
        "dofs",
        "influence",
        "inertia",
        "note",
        "condensed",
        _FACTORS,
    ),
}


def host_from(entry: Mapping[str, Any], statics: Sequence[str] = ()) -> Host:
    """Return the host of a table; a reduction keeps by default the static response of `statics`."""
    table("host", entry, dict.fromkeys(key for keys in KEYS.values() for key in keys))
    sources = ["shape"] if "shape" in entry else [key for key in KEYS if key in entry]
    if len(sources) != 1:
        raise RequestError(
            f"{' beside '.join(sources) or 'no host'}: give one of {', '.join(KEYS)}"
        )
    host = _from_source(sources[0], table(sources[0], entry, KEYS[sources[0]]))
    if "keep" in entry or "below" in entry:
        host = host.reduced(
            entry.get("keep"), below=entry.get("below"), statics=entry.get("statics", statics)
        )
    elif "statics" in entry:
        raise RequestError("statics without a reduction: give keep or below")
    factors = {}
    for key, factor in table(_FACTORS, entry.get(_FACTORS, {}), ("M", "K", "C")).items():
        name = f"{STRUCTURE_ITSELF}.{key}"
        factors[name] = number(f"factors.{key}", factor)
        DESCRIBED[name].check(factors[name])
    return host.with_numbers(factors) if factors else host


def _from_source(source: str, entry: Mapping[str, Any]) -> Host:
    """Return the host of a table before its reduction; `source`: one of `KEYS`."""
    options = {key: entry[key] for key in entry if key in _OPTIONS}
    if source == "file":
        return Host.from_file(string("file", entry["file"]), **options)
    if source == "modes":
        return Host.from_modes(entry["modes"], **options)
    if source in _READY:
        if "C" in entry:
            options["C"] = _rows("C", entry["C"])
        with at(source):
            arguments = [*signature(_READY[source]).parameters.values()][:-1]
            needed = [one.name for one in arguments if one.default is one.empty]
            values = table(source, entry[source], [one.name for one in arguments], needed)
            host: Host = _READY[source](**values, **options)
            return host
    matrices = {key: _rows(key, entry[key]) for key in ("M", "K", "C") if key in entry}
    table(source, entry, needed=["K"] if source == "M" else ["K", "inertia", "dofs"])
    if source == "M":
        return Host(**matrices, **options)
    for name in ("K", "shape"):
        _sequence(name, entry[name])
    shape, inertia = _rows("shape", entry["shape"]), _vector("inertia", entry["inertia"])
    moved = _vector("influence", entry.get("influence", np.ones(len(shape))))
    condensed = _sequence("condensed", entry.get("condensed", []))
    if "M" not in matrices:
        matrices["M"] = np.eye(len(matrices["K"]))
    host = Host(**matrices, ratio=entry.get("ratio"))
    host._in_modes(entry["dofs"], shape, inertia, moved, entry.get("note", ""), condensed)
    if "M" in entry:  # condensed, not reduced
        host.coordinates = host.places
    return host


def table_of(host: Host) -> dict[str, Any]:
    """Return the table that describes exactly a host, by its matrices or by its modes."""
    if scipy.sparse.issparse(host.M):
        raise RequestError(f"a host of {len(host.inertia)} coordinates is too large for a file")
    if host.factors:
        assert host._unscaled is not None
        return {**table_of(host._unscaled), "factors": dict(host.factors)}
    if host.source is not None:
        values = host.source.to_table()
        if "C" in values and not host.condensed:
            values["C"] = _listed(np.asarray(host.C))
        return values
    is_modal = host.coordinates != host.places
    values = {} if is_modal else {"M": _listed(host.M)}
    values["K"], C = _listed(host.K), np.asarray(host.C)
    if host.ratio is not None:
        values["ratio"] = host.ratio.tolist()
    elif C.any():
        values["C"] = _listed(C)
    values |= {"dofs": list(host.dofs), "influence": host.influence.tolist()}
    if not host.is_plain:
        values |= {"inertia": host.inertia.tolist(), "shape": host.shape.tolist()}
        values["note"] = host.note
    if host.condensed:
        values["condensed"] = list(host.condensed)
    return values


def with_influence(host: Host, influence: Mapping[str, float]) -> Host:
    """Return a host whose degrees of freedom move by `influence` when the ground moves by 1."""
    if host._unscaled is not None:
        return with_influence(host._unscaled, influence)._scaled(host.factors)
    table("influence", influence, host.dofs)
    if host.coordinates != host.places:
        raise RequestError(
            "influence: the coordinates are modes; state it where the host is made, "
            "nv.Host(..., influence=[...])"
        )
    values = {dof: number(f"influence.{dof}", factor) for dof, factor in influence.items()}
    host = copy.copy(host)
    host._shake(np.array([values.get(dof, 0.0) for dof in host.dofs]))
    if host.source is not None:
        arguments = {**host.source.arguments, "influence": host.influence}
        host.source = host.source._replace(arguments=arguments)
    return host


def _rows(name: str, value: Any) -> Any:
    """Return a matrix of a file: rows, a diagonal, or a path."""
    if isinstance(value, str):
        return value
    matrix = array_of(name, _sequence(name, value), "rows of numbers")
    return np.diag(matrix) if matrix.ndim == 1 else matrix


def _plain(value: Any) -> Any:
    """Return a value as a request file holds it: arrays and tuples as lists."""
    if isinstance(value, Mapping):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return value.tolist() if hasattr(value, "tolist") else value


def _listed(matrix: np.ndarray) -> list[Any]:
    """Return the rows of a matrix, or its diagonal if there is nothing beside it."""
    diagonal = matrix.diagonal()
    has_others = np.count_nonzero(matrix) > np.count_nonzero(diagonal)
    rows: list[Any] = (matrix if has_others else diagonal).tolist()
    return rows


def modal_damping(ratio: np.ndarray, squares: np.ndarray) -> np.ndarray:
    """Return 2 zeta omega [1/s] of modes with ascending omega^2; the last ratio holds above."""
    missing = max(0, squares.size - ratio.size)
    return 2 * np.pad(ratio, (0, missing), "edge")[: squares.size] * np.sqrt(squares)


def _modes(K: Any, M: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest eigenvalues omega^2 of K phi = omega^2 M phi, and phi by column.

    Each phi has a modal mass of 1 kg, and its largest component is positive.

    Notes
    -----
    LAPACK errs in omega^2 by round-off times the largest one, which exceeds the lowest one by 1e14
    in a beam of 400 elements.  The lowest modes are therefore corrected: the largest eigenvalues of
    V^T M (K + s M)^-1 M V are 1 / (omega^2 + s) of the lowest modes in the span of V, and no digits
    of them cancel.  s is 0 unless K is singular but for round-off.

    A motion is rigid (omega = 0) if its strain energy phi^T K phi is round-off beside the sum of
    K_ii phi_i^2, which no choice of units changes.
    """
    if scipy.sparse.issparse(K):
        squares, vectors, shift = _sparse_modes(K, M, count)
    else:
        shift = 0.0
        squares, vectors = scipy.linalg.eigh(K, M)
        is_low = squares < _CORRECTED * squares[-1]
        if is_low.any():
            # sparse factors, too, as their order of elimination loses fewer digits
            shift, solve = _shifted_solver(scipy.sparse.csc_array(K), scipy.sparse.csc_array(M))
            low_squares, low = _corrected(M, vectors[:, is_low], shift, solve)
            squares = np.concatenate([low_squares, squares[~is_low]])
            vectors = np.hstack([low, vectors[:, ~is_low]])
        squares = squares[:count]
        vectors = vectors[:, :count]
    stiffness = K.diagonal() @ vectors**2 + shift
    largest = np.take_along_axis(vectors, np.abs(vectors).argmax(axis=0)[None], axis=0)
    return np.where(squares <= _RIGID * stiffness, 0.0, squares), vectors * np.sign(largest)


def _sparse_modes(K: Any, M: Any, count: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the lowest omega^2, the modes by column, and the shift that they were computed with.

    By Lanczos' method for 1 / (omega^2 + shift), whose errors are round-off times the largest.
    """
    from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

    n = K.shape[0]
    start = M @ np.random.default_rng(0).standard_normal(n)  # the same modes in each run
    shift, solve = _shifted_solver(K, M)
    while True:
        inverse = LinearOperator((n, n), matvec=solve, dtype=float)
        try:
            _, vectors = eigsh(K, count, M, sigma=-shift, OPinv=inverse, v0=start)
        except ArpackError as error:
            raise RequestError(f"the lowest {count} modes did not converge: {error}") from None
        squares, vectors = _corrected(M, vectors, shift, solve)
        highest = squares[-1] + shift
        if squares[0] + shift > 1e-8 * highest:
            return squares, vectors, shift
        shift, solve = _shifted_solver(K, M, 1e-6 * highest)


def _corrected(
    M: Any, vectors: np.ndarray, shift: float, solve: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Return omega^2, ascending, and the lowest modes in the span of the columns of `vectors`.

    `vectors` have modal masses of 1 and no common ones; `solve` solves (K + shift M) x = b.
    """
    momenta = M @ vectors
    inverse = momenta.T @ solve(momenta)
    _, turned = scipy.linalg.eigh((inverse + inverse.T) / 2)
    modes = vectors @ turned[:, ::-1]
    momenta = M @ modes
    squares = 1 / np.sum(momenta * solve(momenta), axis=0) - shift
    order = np.argsort(squares, kind="stable")
    return squares[order], modes[:, order]


def _shifted_solver(K: Any, M: Any, shift: float = 0.0) -> tuple[float, Any]:
    """Return s >= `shift` and the function that solves (K + s M) x = b, for sparse matrices.

    s is `shift` if K + s M is regular but for round-off, otherwise the least of a geometric row for
    which it is.
    """
    ratios = K.diagonal() / M.diagonal()
    least = ratios[ratios > 0].min() if (ratios > 0).any() else 1.0
    while np.isfinite(shift):
        scaled, scale = _with_unit_diagonal(K + shift * M)
        pivots, solve_scaled = _factor(scaled)
        if pivots.min() > _SAFE_PIVOT:
            return shift, partial(_solve_scaled, scale, solve_scaled)
        shift = 100 * shift or 1e-14 * least
    raise RequestError("K / M exceeds the numbers of a computer: choose other units")


def _solve_scaled(scale: np.ndarray, solve: Any, right: np.ndarray) -> np.ndarray:
    """Return A^-1 b with the solver of D A D, D = diag(scale)."""
    rows = scale if right.ndim == 1 else scale[:, None]
    solution: np.ndarray = rows * solve(rows * right)
    return solution


def _factor(matrix: Any) -> tuple[np.ndarray, Any]:
    """Return the pivots of L D L^T of a symmetric sparse matrix, and the function that solves.

    By Sylvester's law, as many pivots as eigenvalues are negative.  If a pivot is 0, so are all.
    """
    from scipy.sparse.linalg import splu

    try:
        factor = splu(
            matrix.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:  # exactly singular
        return np.zeros(1), None
    pivots = factor.U.diagonal()
    is_symmetric = np.array_equal(factor.perm_r, factor.perm_c)
    return pivots if is_symmetric else np.zeros(1), factor.solve


def _rounding(matrix: Any) -> float:
    """Return the largest relative error of entries that were rounded to decimal digits, or 0.

    That of d digits is 10^(1 - d) / 2.
    """
    entries = np.unique(np.abs(matrix.data if scipy.sparse.issparse(matrix) else matrix))
    entries = entries[np.isfinite(entries) & (entries > 1e-290)]
    if entries.size == 0:
        return 0.0
    powers = np.floor(np.log10(entries))
    for digits in range(1, _ROUNDED.stop):
        # whole numbers of the last digit, but for the round-off of these products
        numbers = entries * 10.0 ** (digits - 1 - powers)
        if (np.abs(numbers - np.rint(numbers)) <= 1e-15 * numbers).all():
            return 0.5 * 10.0 ** (1 - digits) if digits in _ROUNDED else 0.0
    return 0.0


def _below(least: float, matrix: Any) -> str:
    """Return in words which eigenvalues of a symmetric matrix are not above `least`, "" if none."""
    if scipy.sparse.issparse(matrix):
        pivots, _ = _factor(matrix - least * scipy.sparse.eye_array(matrix.shape[0]))
        count = int(np.sum(pivots <= 0))
        sign = "<= 0" if least > 0 else "< 0"
        return f"{count} eigenvalue{'s' * (count > 1)} {sign}" if count else ""
    try:
        scipy.linalg.cholesky(matrix - least * np.eye(len(matrix)))
    except scipy.linalg.LinAlgError:
        lowest = scipy.linalg.eigvalsh(matrix, subset_by_index=[0, 0])[0]
        return f"the eigenvalue {lowest:.4g}"
    return ""


def _with_unit_diagonal(matrix: Any) -> tuple[Any, np.ndarray]:
    """Return D A D of a symmetric A, and D > 0: its diagonal is 1, unless that of A is not > 0.

    An entry beyond 1 makes it indefinite, however large; so 2 stands for more, which may overflow.
    """
    diagonal = matrix.diagonal()
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    if scipy.sparse.issparse(matrix):
        factors = scipy.sparse.diags_array(scale)
        scaled = factors @ matrix @ factors
        scaled.data = scaled.data.clip(-2.0, 2.0)
        return scaled, scale
    with np.errstate(over="ignore"):
        scaled = scale[:, None] * matrix * scale
    return scaled.clip(-2.0, 2.0), scale


def _vector(name: str, value: Any, least: float = -np.inf) -> np.ndarray:
    vector = array_of(name, value, "numbers")
    is_sound = vector.ndim == 1 and vector.size > 0 and np.isfinite(vector).all()
    if np.iscomplexobj(vector) or not is_sound or (vector < least).any():
        bound = "" if least == -np.inf else f" >= {least:g}"
        raise RequestError(f"{name} = {shown(value)} must be finite numbers{bound}")
    return vector


def _sequence(name: str, values: Any) -> tuple[Any, ...]:
    is_scalar = isinstance(values, np.ndarray) and values.ndim == 0
    if isinstance(values, str) or is_scalar or not isinstance(values, Sequence | np.ndarray):
        raise RequestError(f"{name} = {shown(values)} must be a list")
    return tuple(values.tolist() if isinstance(values, np.ndarray) else values)


def _repeated(value: Any, count: int) -> Any:
    """Return several numbers as they are, one number `count` times."""
    return value if isinstance(value, Sequence | np.ndarray) else [value] * count


def _ratios(name: str, value: Any) -> np.ndarray:
    """Return damping ratios, each a number below 1 or a percentage, "2%"."""
    is_scalar = isinstance(value, np.ndarray) and value.ndim == 0
    is_listed = isinstance(value, list | tuple | np.ndarray) and not is_scalar
    values = list(value) if is_listed else [value]
    ratios = _vector(name, [from_percentage(name, one) for one in values], least=0.0)
    for ratio in ratios.tolist():
        refuse_critical(name, ratio)
    return ratios


def _rayleigh(value: Any) -> tuple[float, float]:
    """Return a [1/s] and b [s] of C = a M + b K, stated or by two damping ratios at frequencies.

    A mode of the frequency w has the damping ratio (a / w + b w) / 2.
    """
    if not isinstance(value, Mapping):
        constants = _vector("rayleigh", value, least=0.0)
        if constants.size != 2:
            raise RequestError(
                f"rayleigh = {shown(value)} must be two numbers, a and b, or ratios and f"
            )
        return float(constants[0]), float(constants[1])
    with at("rayleigh"):
        entries = table("rayleigh", value, ("ratios", "f", "omega"), ["ratios"])
        if ("f" in entries) == ("omega" in entries):
            raise RequestError("give one of f [Hz] and omega [rad/s], the two frequencies")
        key = "f" if "f" in entries else "omega"
        ratios = _ratios("ratios", entries["ratios"])
        frequencies = _vector(key, entries[key], least=0.0)
        if ratios.size != 2 or frequencies.size != 2 or frequencies[0] == frequencies[1]:
            raise RequestError(f"ratios and {key} must be two numbers each, {key} different ones")
        omega = frequencies if key == "omega" else 2 * np.pi * frequencies
        with np.errstate(all="ignore"):
            matrix = np.stack([0.5 / omega, 0.5 * omega], axis=1)
            if not np.isfinite(matrix).all():
                raise RequestError(f"{key} = {shown(entries[key])} must be > 0")
            a, b = np.linalg.solve(matrix, ratios)
        if a < 0 or b < 0:
            raise RequestError(
                f"these ratios need a = {a:g} and b = {b:g}, which must be >= 0: give ratio in its "
                "place, with one value for each mode"
            )
        return float(a), float(b)


def _solved(matrix: Any, right: Any) -> np.ndarray:
    """Return the displacements that forces `right` cause; refuse a mechanism."""
    try:
        if scipy.sparse.issparse(matrix):
            from scipy.sparse.linalg import splu

            solution = splu(matrix.tocsc()).solve(right.toarray())
        else:
            factor = scipy.linalg.cho_factor(matrix)
            solution = scipy.linalg.cho_solve(factor, right)
    except (scipy.linalg.LinAlgError, RuntimeError):  # RuntimeError: of a sparse singular matrix
        solution = np.full(right.shape, np.nan)
    if not np.isfinite(solution).all():
        raise RequestError(
            "degrees of freedom without mass cannot be condensed: K leaves them free to move"
        )
    return solution


def _names(dofs: Sequence[str | int], count: int) -> tuple[str, ...]:
    names = tuple(dof_name("dofs", label) for label in _sequence("dofs", dofs))
    names = names or tuple(f"x{i + 1}" for i in range(count))
    for name in names:
        check_name("dofs", name)
        if name in ("ground", "mass"):
            raise RequestError(f"dofs: {shown(name)} has another meaning: take another name")
    if len(names) != count or len(set(names)) < count:
        raise RequestError(f"dofs = {shown(list(names))} must be {count} different names")
    return names
