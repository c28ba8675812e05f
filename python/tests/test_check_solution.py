"""The checker that shares nothing with the program: it passes a good solution and fails whatever was tampered with."""
import json
import pathlib
import subprocess
import sys

import pytest

import lamprey as lp

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "examples" / "check_solution.py"


def run(folder):
    return subprocess.run([sys.executable, str(SCRIPT), str(folder)], capture_output=True, text=True, encoding="utf-8",
                          env={"PYTHONIOENCODING": "utf-8"}, timeout=120)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    folder = tmp_path_factory.mktemp("good")
    lp.solve(lp.load(ROOT / "examples" / "translation.toml").changed(time={"steps": 60})).save(folder)
    return folder


def failed(report):
    return {" ".join(line[2:36].split()) for line in report.stdout.splitlines() if line.startswith("✗")}


def test_a_good_solution_keeps_every_mark(stored):
    report = run(stored)
    assert report.returncode == 0, report.stdout + report.stderr
    assert not failed(report)
    for name in ("cost", "goal_error", "rest_error", "equation_residual", "momentum_drift", "kkt", "replay"):
        assert f"✓ {name}" in report.stdout, name


def test_ellipses_have_the_matrices_of_their_semi_axes(tmp_path):
    lp.solve(lp.load(ROOT / "examples" / "ellipses.toml").changed(time={"steps": 60})).save(tmp_path)
    report = run(tmp_path)
    assert report.returncode == 0, report.stdout + report.stderr
    assert "✓ matrices of head by semi-axes" in report.stdout


def test_joints_that_end_at_rest_on_a_whole_that_drifts_are_stationary(tmp_path):
    problem = lp.load(ROOT / "examples" / "drifting.toml").changed(
        goal={"rest": "joints"}, time={"steps": 100}, search={"starts": 1}, limits=None)
    solution = lp.solve(problem)
    solution.save(tmp_path)
    report = run(tmp_path)
    assert report.returncode == 0, report.stdout + report.stderr
    for name in ("rest_error", "kkt"):
        assert f"✓ {name}" in report.stdout, name


# A tail that its ball joint drives about two axes alone, y and z; one moment is at its limit at times.
TWO_AXES = """
schema = 1
name = "two_axes"
[fluid]
density = 1000.0
[[body]]
name = "head"
semi_axes = [0.3, 0.06, 0.1]
[[body]]
name = "tail"
semi_axes = [0.2, 0.05, 0.1]
[[joint]]
parent = "head"
child = "tail"
parent_offset = [-0.32, 0.0, 0.0]
child_offset = [0.22, 0.0, 0.0]
control_axes = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
[start]
[goal]
angle.tail = [0.0, 0.4, 0.3]
[time]
duration = 2.0
steps = 40
[cost]
effort = 1.0
[search]
starts = 1
[limits]
torque_component.tail = 0.1
"""


def test_components_of_moments_are_along_the_control_axes_in_their_order(tmp_path):
    (tmp_path / "problem.toml").write_text(TWO_AXES, encoding="utf-8")
    lp.solve(lp.load(tmp_path / "problem.toml")).save(tmp_path / "answer")
    solution = json.loads((tmp_path / "answer" / "solution.json").read_text(encoding="utf-8"))
    assert any(max(entry["multiplier"]) > 0.0 for entry in solution["limit_multipliers"])
    report = run(tmp_path / "answer")
    assert report.returncode == 0, report.stdout + report.stderr
    assert "✓ kkt " in report.stdout


def smooth_gait():
    return lp.load(ROOT / "examples" / "gait.toml").changed(
        time={"steps": 60}, cost={"smoothness": 1e-3}, search={"starts": 1})


def smooth_turn():
    return lp.load(ROOT / "examples" / "translation.toml").changed(time={"steps": 60}, cost={"smoothness": 1e-3})


# Second differences of moments leave more of kkt than moments do, and the script has to know it as the certificate does.
@pytest.mark.parametrize("problem, told", [(smooth_gait, ("kkt_round_off", "cost")),
                                           (smooth_turn, ("kkt_round_off", "cost", "kkt"))])
def test_smoothness_leaves_more_round_off_of_kkt(tmp_path, problem, told):
    solution = lp.solve(problem())
    solution.save(tmp_path)
    report = run(tmp_path)
    assert report.returncode == 0, report.stdout + report.stderr
    for name in told:
        assert f"✓ {name} " in report.stdout, name


def control(solution):
    solution["control"][30][0][2] += 1e-3


def cost(solution):
    solution["cost"] *= 0.9


def position(solution):
    solution["position"][20][0] += 1e-6


def mass(solution):
    body = solution["problem"]["bodies"][1]
    body["mass_matrix"] = [[1.01 * entry for entry in row] for row in body["mass_matrix"]]


def goal(solution):
    solution["problem"]["goal"]["move"][0] += 1e-6


def weaker_goal(solution):
    solution["problem"]["goal"]["move"][0] = "free"


def cost_rule(solution):
    step = solution["problem"]["time_step"]
    solution["problem"]["cost_rule"] = "rectangle"
    solution["cost"] = 0.5 * step * sum(u * u for node in solution["control"] for joint in node for u in joint)


def replay(solution):
    solution["certificate"]["replay"]["rotation_error"] *= 0.8


def velocity(solution):
    solution["velocity"]["angular"][30][0][2] += 1e-3


@pytest.mark.parametrize("tamper, name", [
    (control, "equation_residual"), (cost, "cost"), (position, "momentum_drift"), (mass, "momentum_drift"),
    (goal, "goal_error"), (weaker_goal, "kkt"), (cost_rule, "kkt"), (replay, "replay.rotation_error, rad"),
    (velocity, "velocity_error")])
def test_what_was_tampered_with_fails(stored, tmp_path, tamper, name):
    solution = json.loads((stored / "solution.json").read_text(encoding="utf-8"))
    tamper(solution)
    (tmp_path / "solution.json").write_text(json.dumps(solution), encoding="utf-8")
    report = run(tmp_path)
    assert report.returncode == 1, report.stdout + report.stderr
    assert name in failed(report)


def test_what_cannot_be_read_is_one_line(stored, tmp_path):
    assert run(tmp_path).returncode == 2
    solution = json.loads((stored / "solution.json").read_text(encoding="utf-8"))
    del solution["problem"]["steps"]
    (tmp_path / "solution.json").write_text(json.dumps(solution), encoding="utf-8")
    report = run(tmp_path)
    assert report.returncode == 2 and report.stderr.count("\n") == 1 and "steps" in report.stderr


def test_schemes_above_order_2_are_said_not_to_be_covered(stored, tmp_path):
    solution = json.loads((stored / "solution.json").read_text(encoding="utf-8"))
    solution["problem"]["scheme"] = "order4"
    (tmp_path / "solution.json").write_text(json.dumps(solution), encoding="utf-8")
    report = run(tmp_path)
    assert report.returncode == 2 and report.stderr.startswith("not covered: ")
