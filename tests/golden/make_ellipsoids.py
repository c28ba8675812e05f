#!/usr/bin/env python3
"""Golden data for the inertia of solid ellipsoids: hard shapes, evaluated with mpmath at 60 digits by tanh-sinh
quadrature of Lamb's integrals and his cancelling formula for the moment, rounded to doubles.

usage:  make_ellipsoids.py [ellipsoids.json]        (needs mpmath; ten seconds)
"""
import json
import sys

import mpmath as mp

mp.mp.dps = 60

SHAPES = [
    [8.0, 1.5, 2.0], [5.0, 0.8, 1.5], [2.0, 1.0, 1.0], [10.0, 1.0, 1.0], [1.0, 1.0, 0.5], [1.0, 1.0, 1.0],
    [1.0, 2.0, 3.0], [3.0, 1.0, 2.0], [1.0, 1.0, 1.0 + 1e-3], [1.0, 1.0 - 1e-6, 1.0 + 1e-6], [2.0, 1.0, 1.0 + 1e-8],
    [1.0, 2.0, 2.0 - 1e-10], [1.0, 1.0, 1.0 + 2.0**-52], [1e-3, 1.0, 1.0], [1e-3, 1.0, 1.0 + 1e-7], [1.0, 1e-3, 1e-3],
    [1000.0, 1.0, 31.0], [1e3, 1.0, 1.0 + 1e-9], [1e6, 1.0, 1e3], [1.0, 1e-6, 1e-3], [1e6, 1e6, 1.0],
    [1e6, 1e6 + 1e-3, 1.0], [1e-50, 2e-50, 3e-50], [1e60, 2e60, 3e60],
]


def lamb_coefficient(axes, i):
    """abc times the integral of ds/((a_i^2 + s) Delta), s = e^x; split where s equals an axis squared."""
    scale = mp.cbrt(axes[0] * axes[1] * axes[2])
    a = [x / scale for x in axes]

    def integrand(x):
        s = mp.exp(x)
        return s / ((a[i]**2 + s) * mp.sqrt((a[0]**2 + s) * (a[1]**2 + s) * (a[2]**2 + s)))

    knots = sorted({mp.mpf(mp.nstr(2 * mp.log(x), 4)) for x in a})
    tails = [knots[0] - 140, knots[0] - 35, knots[0] - 7] + knots + [knots[-1] + 7, knots[-1] + 35, knots[-1] + 100]
    return mp.quad(integrand, tails)


def ellipsoid(axes):
    a = [mp.mpf(x) for x in axes]
    lamb = [lamb_coefficient(a, i) for i in range(3)]
    assert abs(sum(lamb) - 2) < mp.mpf(10)**-45, (axes, mp.nstr(sum(lamb) - 2, 5))
    added_mass, added_inertia = [], []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        b, c = a[j]**2, a[k]**2
        added_mass.append(lamb[i] / (2 - lamb[i]))
        moment = 0 if b == c else (b - c)**2 * (lamb[k] - lamb[j]) / (5 * (2 * (b - c) + (b + c) * (lamb[j] - lamb[k])))
        added_inertia.append(moment)
    return {"semi_axes": axes, "added_mass": [float(x) for x in added_mass],
            "added_inertia": [float(x) for x in added_inertia]}


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else "ellipsoids.json"
    cases = [json.dumps(ellipsoid(shape)) for shape in SHAPES]
    with open(path, "w") as file:
        file.write('{"description": "added mass over rho V, added inertia (m^2) over rho V, correct to a double",\n')
        file.write(' "cases": [\n  ' + ",\n  ".join(cases) + "\n ]}\n")


if __name__ == "__main__":
    main()
