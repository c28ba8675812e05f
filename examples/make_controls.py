#!/usr/bin/env python3
"""Writes the controls of falling_cat.toml, eel.toml and hinge_fins.toml, t, then 3 columns for each joint, and the joint
angles of three_links.toml.

Each joint has a spring (stiffness k) and a damper (damping c). The moment that holds it at an angle α against its spring
and moves it there against its damper is k α + c dα/dt; as the joint's control it makes the joint follow α as a servo
would, however the fluid and the other bodies push. A control acts on the parent, its opposite on the child, hence the
minus sign. Columns are vectors in the parent's frame with the joint at its zero angle.

usage: make_controls.py [FOLDER]     (default: beside itself)
"""
import math
import pathlib
import sys

E2, E3 = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
CAT_BEND = 1.175  # rad: more or less of it turns the cat by more or less than half a turn


def smooth(t, begin, end):
    """Rises from 0 at `begin` to 1 at `end`, with two derivatives zero at both."""
    s = min(max((t - begin) / (end - begin), 0.0), 1.0)
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)


def rate(angle, t, step=1e-5):
    return (angle(t + step) - angle(t - step)) / (2.0 * step)


def moment(angles, axes, stiffness, damping, t):
    """Control of one joint with these angles (functions of time, rad) about these axes."""
    along = [-(stiffness * angle(t) + damping * rate(angle, t)) for angle in angles]
    return [sum(u * axis[c] for u, axis in zip(along, axes)) for c in range(3)]


def write(path, names, duration, rows, joints):
    with open(path, "w", encoding="utf-8") as out:
        out.write("t," + ",".join(f"{name} {c} (N m)" for name in names for c in "xyz") + "\n")
        for row in range(rows + 1):
            t = duration * row / rows
            numbers = [t] + [u for joint in joints for u in joint(t)]
            out.write(",".join(f"{x + 0.0:.9g}" for x in numbers) + "\n")


def falling_cat(path):
    """The spine bends, the bend goes round the long axis, the spine straightens."""
    bend = lambda t: CAT_BEND * smooth(t, 0.0, 0.12) * (1.0 - smooth(t, 0.38, 0.5))
    round_ = lambda t: 2.0 * math.pi * smooth(t, 0.06, 0.44)
    angles = [lambda t: bend(t) * math.cos(round_(t)), lambda t: bend(t) * math.sin(round_(t))]
    write(path, ["spine"], 0.7, 140, [lambda t: moment(angles, [E2, E3], 40.0, 0.6, t)])


def eel(path):
    """A wave of bending runs from head to tail, stronger towards the tail."""
    def joint(j):
        angle = lambda t: (0.14 + 0.03 * j) * smooth(t, 0.0, 1.0) * (1.0 - smooth(t, 5.0, 6.0)) * math.sin(
            2.0 * math.pi * (1.0 * t - j / 9.0))
        return lambda t: moment([angle], [E3], 5.0, 0.2, t)
    write(path, [f"joint{j + 1}" for j in range(9)], 6.0, 300, [joint(j) for j in range(9)])


def hinge_fins(path):
    """Both fins beat, the left one a quarter of a beat ahead."""
    def joint(phase):
        angle = lambda t: 0.8 * smooth(t, 0.0, 0.5) * (1.0 - smooth(t, 5.5, 6.0)) * math.sin(
            2.0 * math.pi * t + phase)
        return lambda t: moment([angle], [E3], 5.0, 0.5, t)
    write(path, ["left", "right"], 6.0, 240, [joint(0.5 * math.pi), joint(0.0)])


def three_links(path, amplitude=0.7, rows=100):
    """Both joints bend alike, the tail a quarter of a period behind: a circle in the plane of shapes."""
    with open(path, "w", encoding="utf-8") as out:
        out.write("t (s),head (rad),tail (rad)\n")
        for row in range(rows + 1):
            phase = 2.0 * math.pi * row / rows
            out.write(f"{row / rows:.9g},{amplitude * math.cos(phase) + 0.0:.9g},{amplitude * math.sin(phase) + 0.0:.9g}\n")


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent
    falling_cat(folder / "falling_cat_controls.csv")
    eel(folder / "eel_controls.csv")
    hinge_fins(folder / "hinge_fins_controls.csv")
    three_links(folder / "three_links_angles.csv")
