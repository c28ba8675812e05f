"""Files of a solution: what `lamprey solve --out` writes, read and verified again."""
import concurrent.futures
import copy
import json
import multiprocessing
import pickle

import numpy as np
import pytest

import lamprey as lp


def test_saved_solutions_come_back_the_same(solution, tmp_path):
    solution.save(tmp_path / "run")
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == ["report.html", "solution.json", "trajectory.h5"]
    stored = json.loads((tmp_path / "run" / "solution.json").read_text(encoding="utf-8"))
    assert np.array_equal(stored["rotation"], solution.rotation)
    assert np.array_equal(stored["momentum"]["angular"]["fluid"], solution.momentum["angular"]["fluid"])
    assert np.array_equal(stored["velocity"]["linear"], solution.velocity["linear"])
    for word in ("certificate", "search", "solver", "provenance", "problem", "cost", "status", "name", "source"):
        assert stored[word] == getattr(solution, word), word
    assert stored["message"].replace("lamprey solve --resolve", "lamprey.solve(resolve=True)") == solution.message
    assert stored["feedback"]["state_coordinates"] == solution.feedback["state_coordinates"]
    assert np.array_equal(stored["feedback"]["gain"], solution.feedback["gain"])
    again = lp.load_solution(tmp_path / "run")
    assert type(again) is lp.Solution and again.cost == solution.cost
    assert np.array_equal(again.control, solution.control)
    assert (tmp_path / "run" / "trajectory.h5").read_bytes()[:8] == b"\x89HDF\r\n\x1a\n"


def test_threads_save_side_by_side_into_folders_of_their_own_and_into_one(solution, tmp_path):
    def save(n):
        solution.save(tmp_path / str(n % 3))  # threads 0, 3, 6 into one
        return lp.load_solution(tmp_path / str(n % 3)).cost

    with concurrent.futures.ThreadPoolExecutor(4) as threads:
        assert set(threads.map(save, range(24))) == {solution.cost}
    assert not [path for path in tmp_path.rglob("*.partial")]
    for n in range(3):
        assert lp.verify(tmp_path / str(n))["holds"]


def test_what_a_caller_does_to_an_entry_stays_with_the_caller(solution):
    before = solution.certificate["kkt"]
    solution.certificate["kkt"] = 42.0
    solution.search["minima"].clear()
    assert solution.certificate["kkt"] == before and solution.search["minima"]


def test_a_stored_march_comes_back_as_a_trajectory(root, tmp_path):
    lp.simulate(root / "examples" / "tumble.toml", steps=20, duration=0.1).save(tmp_path)
    again = lp.load_solution(tmp_path)
    assert type(again) is lp.Trajectory and again.status == "simulated"
    assert lp.verify(tmp_path)["certificate"]["momentum_drift"] < 1e-12


def test_a_march_that_ended_early_comes_back_as_one_with_its_reason(root, tmp_path):
    problem = lp.load(root / "examples" / "translation.toml").changed(time={"steps": 2})
    march = lp.simulate(problem, lambda t: np.array([[0.0, 0.0, 1e5], [0.0, 0.0, -1e5]]))
    assert march.status == "stalled"
    march.save(tmp_path)
    again = lp.load_solution(tmp_path)
    assert type(again) is lp.Trajectory and again.message == march.message
    assert lp.certify(again).message == march.message


def test_motions_are_pickled_and_copied_without_loss(solution, root, tmp_path):
    march = lp.simulate(root / "examples" / "tumble.toml", steps=20, duration=0.1)
    for motion in (solution, march):
        for again in (pickle.loads(pickle.dumps(motion)), copy.deepcopy(motion)):
            assert type(again) is type(motion)
            motion.save(tmp_path / "first")
            again.save(tmp_path / "again")
            for name in ("solution.json", "trajectory.h5"):
                assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()


def marched(problem):
    return lp.simulate(problem, steps=20, duration=0.1)


def test_motions_return_from_other_processes(root):
    problem = lp.load(root / "examples" / "tumble.toml")
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        first, second = pool.map(marched, [problem, problem])
    assert np.array_equal(first.rotation, second.rotation)
    assert np.array_equal(first.rotation, marched(problem).rotation)


def test_a_pickle_without_a_motion_is_refused(solution):
    class_, state = type(solution), b'{"schema": 1}'
    with pytest.raises(lp.InputError, match="pickle"):
        class_.__new__(class_).__setstate__(state)


def test_verify_recomputes_and_does_not_believe(solution, tmp_path):
    solution.save(tmp_path)
    found = lp.verify(tmp_path)
    assert found["holds"] and found["status"] == "optimal"
    assert found["claims"] == [] and found["trajectory"] == ""
    assert abs(found["certificate"]["replay"]["rotation_error"] / solution.certificate["replay"]["rotation_error"] - 1.0) < 1e-6
    stored = json.loads((tmp_path / "solution.json").read_text(encoding="utf-8"))
    stored["control"][30][0][2] *= 1.001
    (tmp_path / "solution.json").write_text(json.dumps(stored), encoding="utf-8")
    found = lp.verify(tmp_path)
    assert not found["holds"] and found["status"] != "optimal"
    assert found["trajectory"].startswith("control[30][0][2] is ")


def test_verify_compares_the_question(translation, solution, tmp_path):
    solution.save(tmp_path)
    assert lp.verify(tmp_path, problem=translation)["problem"] == []
    found = lp.verify(tmp_path, problem=translation.changed(goal={"move": [1.5, "free", "free"]}))
    assert not found["holds"] and found["status"] == "optimal"
    assert found["problem"] == ["problem.goal.move[0] is 2, the file asks for 1.5"]


def test_verify_names_what_is_claimed_in_vain(solution, tmp_path):
    solution.save(tmp_path)
    stored = json.loads((tmp_path / "solution.json").read_text(encoding="utf-8"))
    stored["certificate"]["replay"]["whole_rotation_error"] = 1e-12
    (tmp_path / "solution.json").write_text(json.dumps(stored), encoding="utf-8")
    found = lp.verify(tmp_path)
    (claim,) = found["claims"]
    assert not found["holds"] and found["status"] == "optimal" and found["trajectory"] == ""
    assert claim["field"] == "replay.whole_rotation_error" and claim["stored"] == 1e-12 < claim["found"]


def test_verify_tells_contradictions_and_truths(solution, tmp_path):
    solution.save(tmp_path)
    stored = json.loads((tmp_path / "solution.json").read_text(encoding="utf-8"))
    stored["search"]["minima"][0]["cost"] = 0.0
    stored["certificate"]["second_order_all_axes"]["positive"] = not stored["certificate"]["second_order_all_axes"]["positive"]
    (tmp_path / "solution.json").write_text(json.dumps(stored), encoding="utf-8")
    claims = {claim["field"]: claim for claim in lp.verify(tmp_path)["claims"]}
    assert claims["search.minima[0].cost"]["contradiction"] == "though the answer costs something"
    for field, claim in claims.items():
        if field.endswith(".positive"):
            assert claim["stored"] in (True, False) and isinstance(claim["stored"], bool) and claim["contradiction"] is None


def test_wrong_results_are_told_with_their_field(solution, tmp_path):
    solution.save(tmp_path)
    stored = json.loads((tmp_path / "solution.json").read_text(encoding="utf-8"))
    stored["rotation"][3][1] = [[1.0, 0.0], [0.0, 1.0]]
    (tmp_path / "solution.json").write_text(json.dumps(stored), encoding="utf-8")
    with pytest.raises(lp.InputError) as raised:
        lp.load_solution(tmp_path)
    assert raised.value.key.startswith("/rotation/3/1") and raised.value.file == str(tmp_path / "solution.json")


def test_the_report_is_one_file_that_asks_for_nothing(solution, tmp_path):
    path = tmp_path / "swim.html"
    solution.report(path)
    assert [entry.name for entry in tmp_path.iterdir()] == ["swim.html"]
    page = path.read_text(encoding="utf-8")
    assert solution.name in page and "243080" in page.replace(",", "").replace("\u202f", "").replace("\u2009", "")
    for outside in ('src="http', "src='http", 'href="http', "url(http", "@import", "<link"):
        assert outside not in page
    with pytest.raises(OSError):
        solution.report(tmp_path / "swim.html" / "below.html")
