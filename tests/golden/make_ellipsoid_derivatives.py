#!/usr/bin/env python3
"""Golden data for the derivatives of an ellipsoid's inertia by its semi-axes: central differences, at 160 digits, of
Lamb's textbook formulas (the cancelling ones) with mpmath's own Carlson functions, rounded to doubles. No formula for
a derivative is used.

usage:  make_ellipsoid_derivatives.py [ellipsoid_derivatives.json]        (needs mpmath; seconds)
"""
import json
import sys

import mpmath as mp

mp.mp.dps = 160
STEP = mp.mpf(10)**-31  # of the axis: error 1e-61 by truncation, 1e-65 or better by rounding

SHAPES = [
    [8.0, 1.5, 2.0], [5.0, 0.8, 1.5], [3.0, 1.0, 10.0], [2.0, 1.0, 1.0], [1.0, 10.0, 10.0], [1.0, 1.0, 1.0],
    [1.0, 1.0, 1.0 + 1e-3], [1.0, 1.0 - 1e-6, 1.0 + 1e-6], [2.0, 1.0, 1.0 + 1e-8], [1.0, 1.0, 1.0 + 2.0**-52],
    [1e-3, 1.0, 1.0], [1e-3, 1.0, 1.0 + 1e-7], [1.0, 1e-3, 1e-3], [1000.0, 1.0, 31.0], [1e6, 1.0, 1e3],
    [1e6, 1e6 + 1e-3, 1.0], [1e-30, 2e-30, 3e-30],
]


def inertia(axes):
    """Volume, then body inertia, added mass and added inertia for unit density."""
    squares = [a**2 for a in axes]
    product = axes[0] * axes[1] * axes[2]
    volume = 4 * mp.pi / 3 * product
    body, mass, moment, lamb = [], [], [], []
    for i in range(3):
        b, c = squares[(i + 1) % 3], squares[(i + 2) % 3]
        lamb.append(2 * product * mp.elliprd(b, c, squares[i]) / 3)
        body.append(volume * (b + c) / 5)
        mass.append(volume * lamb[i] / (2 - lamb[i]))
    assert abs(sum(lamb) - 2) < mp.mpf(10)**-140
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        b, c = squares[j], squares[k]
        moment.append(0 if b == c else volume * (b - c)**2 * (lamb[k] - lamb[j]) /
                      (5 * (2 * (b - c) + (b + c) * (lamb[j] - lamb[k]))))
    return [volume], body, mass, moment


def derivatives(axes):
    a = [mp.mpf(x) for x in axes]
    result = [[[None] * 3 for _ in group] for group in inertia(a)]
    for column in range(3):
        step = STEP * a[column]
        ahead = inertia([x + step * (i == column) for i, x in enumerate(a)])
        behind = inertia([x - step * (i == column) for i, x in enumerate(a)])
        for group, (more, less) in enumerate(zip(ahead, behind)):
            for row in range(len(more)):
                result[group][row][column] = (more[row] - less[row]) / (2 * step)
    zero = mp.mpf(10)**-45 * max(abs(x) for row in result[1] for x in row)  # about an axis of revolution: leftovers
    result[3] = [[x if abs(x) > zero else mp.mpf(0) for x in row] for row in result[3]]
    for degree, group, values in zip((3, 5, 3, 5), result, inertia(a)):  # Euler: homogeneous functions of the axes
        for row, value in zip(group, values):
            size = max(abs(x * y) for x, y in zip(row, a))
            assert abs(sum(x * y for x, y in zip(row, a)) - degree * value) <= mp.mpf(10)**-40 * size
    rounded = [[[float(x) for x in row] for row in group] for group in result]
    return {"semi_axes": axes, "volume": rounded[0][0], "body_inertia": rounded[1], "added_mass": rounded[2],
            "added_inertia": rounded[3]}


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else "ellipsoid_derivatives.json"
    cases = [json.dumps(derivatives(shape)) for shape in SHAPES]
    with open(path, "w") as file:
        file.write('{"description": "d(entry)/d(semi-axis) at unit density, rows entries, columns semi-axes, '
                   'correct to a double",\n')
        file.write(' "cases": [\n  ' + ",\n  ".join(cases) + "\n ]}\n")


if __name__ == "__main__":
    main()
