"""Runs of `lamprey solve`: a problem file with another grid and first guess, and what solution.json says."""
import dataclasses
import json
import pathlib
import re
import subprocess

import numpy

from direct_collocation import Motion
from problem import Path, continuous_quaternions


class Failed(Exception):
    """lamprey did not write an answer."""


@dataclasses.dataclass
class Answer:
    motion: Motion
    status: str
    cost: float
    wall_seconds: float
    processor_seconds: float
    starts: int  # first guesses that it took
    certificate: dict
    provenance: dict

    @property
    def path(self):
        return self.motion.path


def varied(text, values):
    """The problem file with other values of keys that stand in it once."""
    for key, value in values.items():
        text, count = re.subn(rf"(?m)^{key}\s*=[^#\n]*", f"{key} = {value} ", text)
        if count != 1:
            raise Failed(f"{key} stands {count} times in the problem file")
    return text


def solve(program, example, folder, steps, seed, scheme="trapezoid"):
    """From one first guess, on one core."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    text = varied(pathlib.Path(example).read_text(encoding="utf-8"),
                  {"steps": steps, "starts": 1, "seed": seed, "scheme": f'"{scheme}"'})
    text = re.sub(r"(?m)^hops\s*=.*\n", "", text)
    if scheme == "order4":  # whose effort is exact
        text = re.sub(r"(?m)^rule\s*=.*\n", "", text)
    (folder / "problem.toml").write_text(text, encoding="utf-8")
    run = subprocess.run([program, "solve", folder / "problem.toml", "--workers", "1", "--out", folder],
                         stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if run.returncode not in (0, 4):
        raise Failed(f"lamprey solve {folder / 'problem.toml'} ended with code {run.returncode}: {run.stderr.strip()}")
    return read(folder)


def read(folder):
    with open(pathlib.Path(folder) / "solution.json", encoding="utf-8") as stream:
        written = json.load(stream)
    joints = written["problem"]["joints"]
    control = numpy.array(written["control"])
    numbers = []
    for j, joint in enumerate(joints):
        axes = numpy.array(joint["control_axes"]).T
        numbers.append(control[:, j] @ numpy.linalg.pinv(axes).T)
    path = Path(continuous_quaternions(numpy.array(written["rotation"])), numpy.array(written["position"]),
                numpy.hstack(numbers))
    R_root = numpy.array(written["rotation"])[:, 0]
    linear = (R_root @ numpy.array(written["velocity"]["linear"])[..., None])[..., 0]
    solver = written["solver"]
    return Answer(Motion(path, numpy.array(written["velocity"]["angular"]), linear), written["status"], written["cost"],
                  solver["wall_seconds"], solver["processor_seconds"], written["search"]["starts"], written["certificate"],
                  written["provenance"])
