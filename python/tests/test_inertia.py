"""Inertia of ellipsoids against the paper's table and closed forms."""
import numpy as np
import pytest

import lamprey as lp

DENSITY = 0.00994718394324346


def test_the_papers_table_is_met_to_its_digits():
    table = {(8.0, 1.5, 2.0): ([1.0659, 2.1696, 1.6641], [1.3480, 20.1500, 25.3276]),
             (5.0, 0.8, 1.5): ([0.2664, 0.6551, 0.3677], [0.1961, 1.7889, 2.9210])}
    for semi_axes, (mass, inertia) in table.items():
        found = lp.ellipsoid_inertia(semi_axes, DENSITY)
        assert np.abs(np.diag(found["mass_matrix"]) - mass).max() < 5.1e-5
        assert np.abs(np.diag(found["inertia_matrix"]) - inertia).max() < 5.1e-5


def test_a_sphere_drags_half_of_what_it_displaces():
    found = lp.ellipsoid_inertia(np.full(3, 0.7), 1000.0)
    displaced = 4.0 / 3.0 * np.pi * 0.7 ** 3 * 1000.0
    assert abs(found["mass"] / displaced - 1.0) < 1e-14
    assert np.abs(found["added_mass"] / displaced - 0.5).max() < 1e-14
    assert np.array_equal(found["added_inertia"], np.zeros(3))
    assert np.abs(found["body_inertia"] / (0.4 * displaced * 0.49) - 1.0).max() < 1e-14


def test_totals_are_sums():
    found = lp.ellipsoid_inertia([3, 2, 1], 2.0)
    assert np.array_equal(found["mass_matrix"], np.diag(found["added_mass"] + found["mass"]))
    assert np.array_equal(found["inertia_matrix"], np.diag(found["added_inertia"] + found["body_inertia"]))
    assert found["added_mass"][2] > found["added_mass"][1] > found["added_mass"][0] > 0.0


def test_two_semi_axes_are_those_of_an_ellipse_in_the_plane():
    found = lp.ellipsoid_inertia([2.0, 1.0], 3.0)
    assert np.abs(found["added_mass"] - 3.0 * np.pi * np.array([1.0, 4.0, 0.0])).max() < 1e-13
    assert abs(found["added_inertia"][2] - 3.0 * np.pi * 9.0 / 8.0) < 1e-13


@pytest.mark.parametrize("semi_axes, density", [([1.0], 1.0), ([1.0, -2.0], 1.0), ([1.0, -2.0, 3.0], 1.0), ([1.0, 2.0, "x"], 1.0),
                                                ([1.0, 2.0, float("inf")], 1.0), ([1.0, 2.0, 3.0], -1.0)])
def test_what_is_no_ellipsoid_is_refused(semi_axes, density):
    with pytest.raises(lp.InputError, match="semi_axes"):
        lp.ellipsoid_inertia(semi_axes, density)
