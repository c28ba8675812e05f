"""The Solver: from its last answer on, as goal, start and time move."""
import re
import subprocess
import sys
import threading

import numpy as np
import pytest

import lamprey as lp
from motion import about_e3, total_momentum


@pytest.fixture
def solver(translation, solution):
    return lp.Solver(translation, solution)


def test_it_begins_at_the_solution(solver, solution):
    assert solver.cost == solution.cost
    assert np.array_equal(solver.path["rotation"], solution.rotation)
    outcome = solver.solve()
    assert outcome.status == "optimal"
    assert abs(solver.cost / solution.cost - 1.0) < 1e-9


def test_a_goal_that_moves_by_a_hundredth_is_found_as_from_scratch(translation, solver, solution):
    solver.set_goal(move=[2.02, "free", "free"])
    outcome = solver.solve()
    assert outcome.status == "optimal" and outcome.iterations <= 6
    scratch = lp.solve(translation.changed(goal={"move": [2.02, "free", "free"]}))
    assert abs(solver.cost / scratch.cost - 1.0) < 1e-8
    assert abs(solver.cost / solution.cost - 1.0) > 1e-3
    assert np.abs(solver.path["rotation"] - scratch.rotation).max() < 1e-6
    certified = lp.certify(solver.solution())
    assert certified.status == "optimal"
    assert certified.certificate["kkt"] < 1e-8 and certified.certificate["goal_error"] < 1e-10
    assert abs(certified.position[-1, 0] - 2.02) < 1e-10


def test_wrong_goals_and_problems_are_named(solver):
    for wrong, named in ((0.05, r"move: found 0\.05; "), (["a", 1, 2], r"move: found 'a' as entry 0; ")):
        with pytest.raises(lp.InputError, match=named):
            solver.set_goal(move=wrong)
    with pytest.raises(TypeError, match="problem: found int; allowed: a Problem, its settings as a dict, or the path"):
        lp.solve(42)


def test_a_plan_goes_on_as_time_passes(translation, solver, solution):
    plan = solver.solution(feedback=True)
    assert len(plan.feedback["time"]) == len(plan.time)
    cost, passed = [solver.cost], 0.1 * solution.time[-1]
    for _ in range(3):
        solver.advance(passed)
        assert not solver.answered
        seen = solver.path["rotation"][0]
        outcome = solver.solve()
        assert outcome.status == "optimal" and solver.answered and outcome.iterations <= 8
        assert not np.array_equal(seen, solver.path["rotation"][0])
        cost.append(solver.cost)
    assert abs(solver.solution().time[-1] / solution.time[-1] - 0.7) < 1e-12
    assert np.abs(solver.path["position"][-1] - solution.position[-1]).max() < 1e-3
    assert cost == sorted(cost, reverse=True)
    certified = lp.certify(solver.solution())
    assert certified.status == "optimal" and certified.certificate["goal_error"] < 1e-10
    rest = solver.solution(feedback=True)
    assert rest.feedback["gain"].shape == plan.feedback["gain"].shape
    with pytest.raises(lp.InputError, match=r"elapsed: found 2 s; allowed: less than the 0\.7 s"):
        solver.advance(2.0)


def test_without_a_new_plan_the_rest_of_the_last_one_is_followed(translation, solution):
    solver = lp.Solver(translation, solution)
    plan, left = solver.solution(feedback=True), 0.7 * solution.time[-1]
    for part in (0.1, 0.2):
        solver.advance(part * solution.time[-1])
        moved = np.array(solver.path["rotation"][0])
        start = lp.simulate(translation, feedback=plan, duration=solver.passed, steps=100)
        cosine, sine = np.cos(1e-3), np.sin(1e-3)
        turned = start.rotation[-1] @ np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
        solver.set_start(turned, start.position[-1], start.velocity["angular"][-1])
        assert solver.solve(max_iterations=1).status == "stalled" and not solver.answered
        assert np.array_equal(solver.path["rotation"][0], moved)
    assert abs(solver.passed + left - solution.time[-1]) < 1e-12
    rest = lp.simulate(translation, feedback=solver.solution(feedback=True), feedback_from=solver.passed)
    assert abs(rest.time[-1] - left) < 1e-12
    with pytest.raises(lp.InputError, match="feedback_from: found without feedback"):
        lp.simulate(translation, feedback_from=0.1)
    with pytest.raises(lp.InputError, match="feedback_from: found -1; allowed: from 0 on"):
        lp.simulate(translation, feedback=plan, feedback_from=-1.0)
    assert solver.solve().status == "optimal" and solver.passed == 0.0


def test_the_example_misses_least_where_plans_are_made_anew(root):
    script = root / "examples" / "receding_horizon.py"
    run = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    one, followed, anew = (float(rad) for rad in re.findall(r"misses by (\S+) rad$", run.stdout, re.MULTILINE))
    assert one > 1.0 and followed < 0.02 and anew < 0.5 * followed
    assert run.stdout.count(": optimal in ") == 9


def test_the_example_plans_anew_for_a_swimmer_that_drifts(root):
    script = root / "examples" / "receding_horizon.py"
    run = subprocess.run([sys.executable, str(script), str(root / "examples" / "drifting.toml")], capture_output=True,
                         text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    one, followed, anew = (float(rad) for rad in re.findall(r"misses by (\S+) rad$", run.stdout, re.MULTILINE))
    assert followed < 0.1 * one and anew < 0.5 * followed and anew < 1e-3, run.stdout  # gains hold the plan, too
    assert run.stdout.count(": optimal in ") == 9


def test_a_start_is_taken_with_the_momentum_that_is_seen(root, translation, solution):
    problem = lp.load(root / "examples" / "drifting.toml").changed(time={"steps": 100}, search={"starts": 1},
                                                                         limits={"torque": 50.0})
    found = lp.solve(problem, workers=1, refinement=False)
    solver = lp.Solver(problem, found)
    rates, drift = found.velocity["angular"][0], found.rotation[0, 0] @ found.velocity["linear"][0]
    pushed = drift + np.array([0.01, -0.01, 0.005])
    solver.set_start(found.rotation[0], found.position[0], rates, linear_velocity=pushed)
    assert solver.solve().status == "optimal"
    again = lp.certify(solver.solution())
    assert again.status == "optimal" and again.certificate["momentum_drift"] < 1e-11
    assert np.abs(again.rotation[0, 0] @ again.velocity["linear"][0] - pushed).max() < 1e-9
    solver.set_start(found.rotation[0], found.position[0], rates)  # the whole without momentum
    assert solver.solve().status == "optimal"
    linear, angular = total_momentum(solver.solution())
    assert np.abs(linear).max() + np.abs(angular).max() < 1e-9
    with pytest.raises(lp.InputError, match="start: found total momentum"):
        lp.Solver(translation, solution).set_start(solution.rotation[0], [0.0, 0.0, 0.0],
                                                   np.zeros((3, 3)), linear_velocity=[0.1, 0.0, 0.0])
    with pytest.raises(lp.InputError, match="angular_velocity: missing"):
        solver.set_start(found.rotation[0], found.position[0], linear_velocity=drift)
    with pytest.raises(lp.InputError, match="linear_velocity"):
        solver.set_start(found.rotation[0], found.position[0], rates, linear_velocity=[0.1, 0.0])


def test_bounds_of_a_free_duration_are_of_the_time_that_is_left(root):
    problem = lp.load(root / "examples" / "free_time.toml").changed(time={"steps": 40}, search={"starts": 1})
    solution = lp.solve(problem)
    solver = lp.Solver(problem, solution)
    passed = 0.25 * solution.time[-1]
    solver.advance(passed)
    assert solver.solve().status == "optimal"
    assert abs((passed + solver.solution().time[-1]) / solution.time[-1] - 1.0) < 0.01
    assert lp.certify(solver.solution()).certificate["limits"]["violation"] < 1e-8


def test_limits_and_free_durations_go_on_too(root):
    problem = lp.load(root / "examples" / "free_time.toml").changed(time={"steps": 40}, search={"starts": 1})
    solution = lp.solve(problem)
    solver = lp.Solver(problem, solution)
    solver.set_goal(move=[2.02, "free", "free"])
    assert solver.solve().status == "optimal"
    assert 1e-4 < abs(solver.solution().time[-1] / solution.time[-1] - 1.0) < 0.1
    certified = lp.certify(solver.solution())
    assert certified.status == "optimal"
    assert certified.certificate["limits"]["violation"] < 1e-8


def test_iterations_within_limits_are_bounded_in_all(root):
    problem = lp.load(root / "examples/free_time.toml").changed(time={"steps": 40}, search={"starts": 2})
    solver = lp.Solver(problem, lp.solve(problem))
    solver.set_goal(move=[2.3, "free", "free"])
    outcome = solver.solve(max_iterations=9)
    assert outcome.iterations <= 9 and outcome.status == "stalled" and "9 iterations" in outcome.reason
    assert solver.solve().status == "optimal"


def test_the_certificate_sees_a_goal_that_was_not_met(translation, solver):
    solver.set_goal(move=[2.5, "free", "free"])
    assert solver.solve(max_iterations=0).status == "stalled"
    assert not solver.answered
    before = solver.solution()
    assert abs(before.position[-1, 0] - 2.0) < 1e-10  # the last answer stays


def test_ends_of_joints_are_goals_too(root):
    problem = lp.load(root / "examples" / "hinge_fins.toml").changed(time={"steps": 60}, search={"starts": 2})
    name = "left"
    problem = problem.changed(goal={"turn": None, "rotation": {}, "angle": {name: 0.3}, "move": ["free"] * 3})
    solver = lp.Solver(problem, lp.solve(problem))
    solver.set_goal(angle={name: 0.32})
    assert solver.solve().status == "optimal"
    told = solver.solution()
    assert told.problem["goal"]["angle"] == {name: pytest.approx([0.32], abs=1e-14)}
    assert lp.certify(told).certificate["goal_error"] < 1e-9
    for wrong, words in (([0.1, 0.2], "one number"), (float("nan"), "not finite"), (40.0, "2 pi")):
        with pytest.raises(lp.InputError, match=words):
            solver.set_goal(angle={name: wrong})
    with pytest.raises(lp.InputError, match="no joint that turns"):
        solver.set_goal(angle={"nobody": 0.1})


def test_turns_and_named_rotations_are_goals_too(solver):
    solver.set_goal(turn=[0.0, 0.0, 0.02])
    assert solver.solve().status == "optimal"
    turned = solver.path["rotation"]
    assert np.abs(turned[-1] - about_e3(0.02) @ turned[0]).max() < 1e-9
    solver.set_goal(rotation={"front": np.array([0.0, 0.0, 0.05])})
    assert solver.solve().status == "optimal"
    assert np.abs(solver.path["rotation"][-1, 1] - about_e3(0.05)).max() < 1e-9
    assert lp.certify(solver.solution()).status == "optimal"


def test_another_start_is_taken_as_measured_and_the_goal_stays_in_the_world(solver, solution):
    seen = solution.rotation[0].copy()
    seen[2] = seen[2] @ about_e3(0.02)
    solver.set_start(seen, [0.05, -0.03, 0.0])
    solver.set_duration(0.95)
    assert solver.solve().status == "optimal"
    found = lp.certify(solver.solution())
    assert found.status == "optimal" and found.certificate["kkt"] < 1e-8
    assert np.abs(found.rotation[0] - seen).max() < 1e-14
    assert np.abs(found.position[0] - [0.05, -0.03, 0.0]).max() < 1e-15
    assert np.abs(found.rotation[-1] - solution.rotation[-1]).max() < 1e-9
    assert abs(found.position[-1, 0] - solution.position[-1, 0]) < 1e-9
    assert abs(found.time[-1] - 0.95) < 1e-15


def test_of_measured_velocities_the_joints_rates_alone_count(translation, solution):
    node = 20
    left = translation.changed(time={"duration": 0.8, "steps": 100})
    rates = solution.velocity["angular"][node]
    drifting = rates + np.einsum("bji,j->bi", solution.rotation[node], [0.0, 0.0, 0.7])
    found = []
    for angular_velocity in (rates, drifting):
        solver = lp.Solver(translation, solution)
        solver.set_start(solution.rotation[node], solution.position[node], angular_velocity)
        solver.set_duration(left.duration)
        assert solver.solve().status == "optimal"
        found.append(solver.solution())
    assert np.abs(found[0].velocity["angular"][0] - rates).max() < 1e-8 * np.abs(rates).max()
    assert np.abs(found[0].rotation - found[1].rotation).max() < 1e-9
    linear, angular = total_momentum(found[1])
    assert np.abs(linear).max() + np.abs(angular).max() < 1e-9
    # what is left of an optimal maneuver is optimal: moments are those that were planned, on another grid
    planned = np.interp(found[0].time + 0.2, solution.time, solution.control[:, 0, 2])
    assert np.abs(found[0].control[:, 0, 2] - planned).max() < 0.01 * np.abs(planned).max()


def test_a_problem_without_a_goal_is_refused(translation, solution):
    settings = dict(translation.settings)
    del settings["goal"]
    with pytest.raises(lp.InputError, match="found no goal, which a Solver does not take"):
        lp.Solver(lp.Problem(settings), solution)


def test_a_turn_that_every_rotation_would_override_is_refused(solver):
    solver.set_goal(rotation={"middle": [0.0, 0.0, 0.0], "front": [0.0, 0.0, 0.0], "back": [0.0, 0.0, np.pi / 4]})
    with pytest.raises(lp.InputError, match="turn: found it where the goal gives every body's rotation"):
        solver.set_goal(turn=[0.0, 0.0, 0.1])


def test_goals_out_of_reach_are_a_status(solver, solution):
    solver.set_goal(turn=[0.1, 0.0, 0.0])
    outcome = solver.solve()
    assert outcome.status == "infeasible" and "cannot reach" in outcome.reason
    assert solver.cost == solution.cost
    assert not solver.answered
    solver.set_goal(turn=[0.0, 0.0, 0.0])
    assert solver.solve().status == "optimal" and solver.answered


def test_what_does_not_fit_is_named(translation, solution, solver):
    for arguments, key in (({"move": [1.0, 2.0]}, "move"), ({"move": [float("nan"), "free", "free"]}, "move"),
                           ({"turn": [[1.0]]}, "turn"), ({"rotation": {"tail": [0.0, 0.0, 0.0]}}, "rotation.tail"),
                           ({"move": ["free", "free", "free"]}, "goal")):
        with pytest.raises(lp.InputError) as raised:
            solver.set_goal(**arguments)
        assert raised.value.key == key
    with pytest.raises(lp.InputError, match=r"rotation\[1\]: .* no rotation"):
        solver.set_start(solution.rotation[0] * [[[1.0]], [[1.1]], [[1.0]]], [0.0, 0.0, 0.0])
    with pytest.raises(lp.InputError, match=r"rotation: .*\[2\]\[3\]\[3\]; allowed: \[3\]\[3\]\[3\]"):
        solver.set_start(solution.rotation[0][:2], [0.0, 0.0, 0.0])
    with pytest.raises(lp.InputError, match="duration"):
        solver.set_duration(0.0)
    with pytest.raises(lp.InputError, match="nodes"):
        lp.Solver(translation.changed(time={"steps": 50}), solution)
    with pytest.raises(lp.InputError, match="a Solver does not take"):
        lp.Solver(translation.changed(control={"kind": "spline", "points": 11}), solution)


@pytest.mark.parametrize("noise", [0.0, 1e-9, 1e-3])
def test_measured_rotations_are_made_to_fit_their_hinges(root, noise):
    problem = lp.load(root / "bench/problems/three_hinges.toml")
    solution = lp.solve(problem, workers=1, refinement=False)
    solver = lp.Solver(problem, solution)
    random = np.random.default_rng(3)
    measured = solution.rotation[0].copy()
    for i in range(1, len(measured)):  # what a camera sees
        x, y, z = 0.5 * noise * random.standard_normal(3)
        turn = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        measured[i] = measured[i] @ np.linalg.solve(np.eye(3) - turn, np.eye(3) + turn)
    solver.set_start(measured, solution.position[0])
    assert solver.solve().status == "optimal"
    assert lp.certify(solver.solution()).status == "optimal"


def test_rotations_that_no_measurement_explains_are_refused(root):
    problem = lp.load(root / "bench/problems/three_hinges.toml")
    solution = lp.solve(problem, workers=1, refinement=False)
    wrong = solution.rotation[0].copy()
    wrong[-1] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    with pytest.raises(lp.InputError, match="beside what joint"):
        lp.Solver(problem, solution).set_start(wrong, solution.position[0])


def test_numbers_that_mean_nothing_are_refused(solver):
    for wrong in ({"max_iterations": -5}, {"time_limit": -1.0}, {"time_limit": float("nan")}):
        with pytest.raises(lp.InputError, match="allowed"):
            solver.solve(**wrong)


def test_it_is_for_one_thread_at_a_time(translation):
    fine = translation.changed(time={"steps": 500}, search={"starts": 1})
    solver = lp.Solver(fine, lp.solve(fine, refinement=False))
    solver.set_goal(move=[2.2, "free", "free"])
    refused, worker = [], threading.Thread(target=solver.solve)
    worker.start()
    while worker.is_alive():
        try:
            solver.set_duration(1.0)
        except RuntimeError as error:
            refused.append(str(error))
            break
    worker.join()
    assert refused and "one thread at a time" in refused[0]


@pytest.mark.parametrize("turn", [[0.0, 0.0, 0.0], "free"])
def test_gaits_are_certified_and_verified_wherever_their_goal_moves(root, tmp_path, turn):
    gait = lp.load(root / "examples" / "gait.toml")
    settings = gait.settings
    settings["goal"]["turn"] = turn
    settings["search"]["starts"] = 1
    gait = lp.Problem(settings)
    solver = lp.Solver(gait, lp.solve(gait, refinement=False))
    solver.set_goal(move=[2.02, "free", "free"])
    assert solver.solve().status == "optimal"
    found = lp.certify(solver.solution())
    assert found.status == "optimal", found.message
    solver.solution().save(tmp_path / "gait")
    assert lp.verify(tmp_path / "gait")["holds"]


def test_a_gait_that_turns_on_its_way_turns_its_root_alone(root):
    gait = lp.load(root / "examples" / "gait.toml").changed(
        time={"steps": 40}, search={"starts": 1}, waypoint=[{"time": 0.5, "turn": [0.0, 0.0, 0.05]}]
    )
    solver = lp.Solver(gait, lp.solve(gait, refinement=False))
    solver.set_goal(move=[2.01, "free", "free"])
    assert solver.solve().status == "optimal"
    certified = lp.certify(solver.solution())
    assert certified.status == "optimal", certified.message
