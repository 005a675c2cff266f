"""Matrices that finite element programs wrote, with the frequencies that they found themselves."""

import numpy as np
import pytest
import scipy.sparse
from support import REPO

import nlds_vines as nv

FILES = REPO / "tests" / "reference" / "finite_elements"


def mirrored(path):
    rows, columns, values = np.loadtxt(path, unpack=True)
    places = rows.astype(int) - 1, columns.astype(int) - 1
    half = scipy.sparse.coo_array((values, places))
    return half + half.T - scipy.sparse.diags_array(half.diagonal())


def test_a_beam_of_calculix_has_the_frequencies_that_calculix_finds():
    """One C3D8 of steel, 1 m by 0.1 m by 0.1 m, held at one end; *FREQUENCY of version 2.20."""
    dofs = [name.replace(".", "_") for name in (FILES / "calculix.dof").read_text().split()]
    host = nv.Host(mirrored(FILES / "calculix.mas"), mirrored(FILES / "calculix.sti"), dofs=dofs)
    assert host.frequencies[:2] == pytest.approx([0.2816423e4] * 2, rel=5e-7)
    assert host.dofs[:4] == ("102_1", "102_2", "102_3", "103_1")
    along = [name.endswith("_2") for name in dofs]
    # displacements grow from 0 to 1 along the beam: a third of its 78 kg
    assert (host.M @ along)[along].sum() == pytest.approx(26.0, rel=1e-12)


def test_a_frame_of_opensees_has_the_frequencies_that_opensees_finds():
    """Two columns of 3 m, EI = 6e6 N m^2, masses of 10 and 8 t without inertia; version 3.7.1."""
    found = [3.0416973, 18.52374233, 243.79017166, 611.47337271]
    dofs = [f"{node}{direction}" for node in (2, 3) for direction in ("ux", "uy", "rz")]
    mass, stiffness = FILES / "opensees_mass.txt", FILES / "opensees_stiffness.txt"
    host = nv.Host(mass, stiffness, dofs=dofs, condense=True)
    assert host.condensed == ("2rz", "3rz")
    assert host.frequencies == pytest.approx(found, rel=1e-8)
    # `printA -file` writes six digits, and a blank at the end of each row
    printed = nv.Host(mass, FILES / "opensees_printed.txt", condense=True)
    assert printed.frequencies == pytest.approx(found, rel=1e-5)


def test_matrix_market_is_known_by_its_first_line_too(here):
    """ANSYS' *EXPORT writes it under any name."""
    banner = "%%MatrixMarket matrix coordinate real symmetric\n"
    (here / "K.txt").write_text(f"{banner}2 2 3\n1 1 1.6e7\n2 1 -8e6\n2 2 8e6\n")
    host = nv.Host(np.diag([2e4, 1e4]), "K.txt")
    assert host.K.tolist() == [[1.6e7, -8e6], [-8e6, 8e6]]
