"""Solutions: shapes, laws from the arrays alone, options, statuses."""
import threading
import time

import numpy as np
import pytest

import lamprey as lp
from motion import about_e3, orthogonality, total_momentum


def test_the_planar_translation_costs_what_it_costs(solution):
    assert solution.status == "optimal"
    assert abs(solution.cost - 243080.02) < 0.01
    assert solution.certificate["kkt"] < 1e-8
    assert solution.certificate["goal_error"] < 1e-9
    assert solution.certificate["second_order"]["positive"] is True
    assert solution.search["starts"] == 8
    assert solution.solver["name"] == "lamprey newton"


def test_arrays_have_the_shapes_of_the_interface(solution):
    assert solution.time.shape == (101,)
    assert solution.position.shape == (101, 3)
    assert solution.rotation.shape == (101, 3, 3, 3)
    assert solution.control.shape == (101, 2, 3)
    assert solution.velocity["linear"].shape == (101, 3)
    assert solution.velocity["angular"].shape == (101, 3, 3)
    for kind in ("linear", "angular"):
        for part in ("bodies", "fluid", "total"):
            assert solution.momentum[kind][part].shape == (101, 3)
    assert solution.control_stages is None and solution.stage_time is None
    assert solution.feedback["gain"].shape == (len(solution.feedback["time"]), len(solution.feedback["control_coordinates"]),
                                               len(solution.feedback["state_coordinates"]))
    assert solution.rotation.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        solution.rotation[0] = 0.0


def test_the_motion_begins_and_ends_as_asked(solution):
    ends = solution.rotation[-1]
    start = solution.rotation[0]
    assert np.abs(start - [np.eye(3), np.eye(3), about_e3(np.pi / 4)]).max() < 1e-14
    assert np.abs(ends - start).max() < 1e-12
    assert abs(solution.position[-1, 0] - solution.position[0, 0] - 2.0) < 1e-12
    assert np.abs(solution.velocity["angular"][[0, -1]]).max() < 1e-10
    assert np.abs(solution.velocity["angular"]).max() > 1.0  # it does move


def test_rotations_are_orthogonal_and_momentum_is_zero_by_the_arrays_alone(solution):
    assert orthogonality(solution.rotation) < 1e-13
    linear, angular = total_momentum(solution)
    scale = np.abs(solution.momentum["angular"]["bodies"]).max()
    assert scale > 1.0
    assert np.abs(linear).max() < 1e-11 * scale and np.abs(angular).max() < 1e-11 * scale


def test_the_check_of_momentum_sees_a_wrong_velocity(solution):
    class Drifting:
        problem, rotation, position = solution.problem, solution.rotation, solution.position
        velocity = {**solution.velocity, "linear": solution.velocity["linear"] + [1e-3, 0.0, 0.0]}

    assert np.abs(total_momentum(Drifting)[0]).max() > 1e-4


def test_the_cost_is_that_of_the_moments(solution):
    weight = np.full(101, 0.01)
    weight[[0, -1]] *= 0.5
    assert abs(0.5 * weight @ (solution.control ** 2).sum(axis=(1, 2)) / solution.cost - 1.0) < 1e-12


def test_the_answer_does_not_depend_on_workers_and_ipopt_agrees(translation, solution):
    one = lp.solve(translation, workers=1, refinement=False)
    assert np.array_equal(one.rotation, solution.rotation)
    assert one.certificate["refinement"] is None and solution.certificate["refinement"] is not None
    other = lp.solve(translation.changed(search={"starts": 2}), solver="ipopt", workers=2, refinement=False)
    assert other.solver["name"] == "ipopt"
    assert any(abs(minimum["cost"] / solution.cost - 1.0) < 1e-6 for minimum in solution.search["minima"])
    assert other.status == "optimal"
    assert abs(other.cost / solution.cost - 1.0) < 1e-6


def test_other_minima_are_kept_where_they_are_asked_for(root, tmp_path):
    problem = lp.load(root / "examples" / "rotation.toml").changed(
        time={"steps": 100, "duration": 1.0}, search={"starts": 8, "keep": 3})
    best = lp.solve(problem, refinement=False)
    costs = [best.cost] + [other.cost for other in best.others]
    assert len(costs) == 3 and costs == sorted(costs)
    assert all(other.certificate["verdict"] == "proved local minimum" and other.others == [] for other in best.others)
    best.save(tmp_path / "run")
    assert lp.load_solution(tmp_path / "run" / "minimum_3").cost == costs[2]
    lp.load_solution(tmp_path / "run").save(tmp_path / "run")  # which knows of no others, and leaves them alone
    assert lp.load_solution(tmp_path / "run" / "minimum_2").cost == costs[1]
    lp.solve(problem.changed(search={"keep": 1}), refinement=False).save(tmp_path / "run")
    assert not (tmp_path / "run" / "minimum_2").exists()


def test_steps_that_do_not_resolve_an_answer_are_a_first_look(root):
    problem = lp.load(root / "examples" / "rotation.toml").changed(
        time={"steps": 60, "duration": 1.0}, search={"starts": 4})
    coarse = lp.solve(problem, refinement=False)
    fine = lp.solve(problem, refinement=False, resolve=True)
    assert not coarse.certificate["resolved"] and fine.certificate["resolved"]
    assert len(coarse.time) == 61 and len(fine.time) > 61
    assert fine.duration == coarse.duration == 1.0


def test_not_arriving_is_a_status(translation):
    late = lp.solve(translation.changed(time={"steps": 2000}), time_limit=1e-3)
    assert late.status == "time_limit" and late.message
    path = lp.solve(translation.changed(goal={"turn": [0.3, 0.0, 0.0]}, search={"starts": 1}))
    assert path.status in ("infeasible", "stalled") and path.message


def test_progress_is_told_and_what_it_raises_ends_the_search(translation):
    lines = []
    few = translation.changed(time={"steps": 20}, search={"starts": 3})
    lp.solve(few, progress=lines.append)
    assert any(line.startswith("first guess 3 of 3") for line in lines)

    told = []

    def fails(line):
        told.append(line)
        raise RuntimeError("no more lines")

    begin = time.monotonic()
    with pytest.raises(RuntimeError, match="no more lines") as raised:
        lp.solve(translation.changed(search={"starts": 100000}), progress=fails)
    assert time.monotonic() - begin < 30.0
    assert len(told) == 1, "nothing is told after it"
    assert raised.value.solution.status == "interrupted"


@pytest.mark.parametrize("options, key", [({"workers": 0}, "workers"), ({"solver": "magic"}, "solver"),
                                          ({"time_limit": -1.0}, "time_limit"), ({"time_limit": float("nan")}, "time_limit")])
def test_wrong_options_are_named(translation, options, key):
    with pytest.raises(lp.InputError) as raised:
        lp.solve(translation, **options)
    assert raised.value.key == key


def test_what_is_not_solved_is_said_with_the_files_line(root):
    with pytest.raises(lp.InputError, match=r"tumble\.toml:\d+:\d+: goal: "):
        lp.solve(root / "examples" / "tumble.toml")


def test_a_search_leaves_python_running(translation):
    ticks, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            time.sleep(0.001)
            ticks[0] += 1

    counter = threading.Thread(target=count)
    counter.start()
    try:
        begin, before = time.perf_counter(), ticks[0]
        lp.solve(translation.changed(time={"steps": 400}), workers=1)
        seconds, counted = time.perf_counter() - begin, ticks[0] - before
    finally:
        stop.set()
        counter.join()
    assert seconds > 0.2  # long enough to tell
    assert counted > 50 * seconds


def test_a_search_begins_at_a_motion(translation, solution, tmp_path):
    farther = translation.changed(goal={"move": [2.2, "free", "free"]})
    found = lp.solve(farther, first=solution)
    assert found.status == "optimal" and found.solver["iterations"] < lp.solve(farther).solver["iterations"]
    solution.save(tmp_path / "run")
    assert np.array_equal(lp.solve(farther, first=tmp_path / "run").rotation, found.rotation)
    with pytest.raises(TypeError):
        lp.solve(farther, first=3)
