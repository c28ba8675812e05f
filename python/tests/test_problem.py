"""Problems: files, dicts, and what is said of wrong ones."""
import pathlib
import pickle
import tomllib

import numpy as np
import pytest

import lamprey as lp

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = sorted((ROOT / "examples").rglob("*.toml"))


def test_there_are_examples():
    assert len(EXAMPLES) >= 15


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: str(path.relative_to(ROOT)))
def test_an_example_loads_and_is_the_same_from_its_dict(path):
    problem = lp.load(path)
    written = tomllib.loads(path.read_text(encoding="utf-8"))
    assert problem.bodies == [body["name"] for body in written["body"]]
    assert problem.joints == [joint.get("name", joint["child"]) for joint in written.get("joint", [])]
    assert problem.steps == written["time"]["steps"]
    assert problem.settings == written
    again = lp.Problem(problem.settings)
    assert again.settings == written
    if "name" in written:  # otherwise it is the file's
        assert again.check() == problem.check()


def test_a_problem_is_made_of_numpy_arrays_and_survives_pickling():
    settings = lp.load(ROOT / "examples" / "translation.toml").settings
    settings["goal"]["turn"] = np.array([0.0, 0.0, 0.25])
    settings["time"]["steps"] = np.int64(40)
    settings["start"]["rotation"]["back"] = np.float64(0.5) * np.array([0, 0, 1])
    problem = pickle.loads(pickle.dumps(lp.Problem(settings)))
    assert problem.steps == 40
    assert problem.settings["goal"]["turn"] == [0.0, 0.0, 0.25]
    assert problem.settings["start"]["rotation"]["back"] == [0.0, 0.0, 0.5]


def test_names_that_toml_would_quote_come_through():
    problem = lp.Problem({"schema": 1, "name": 'a "fish"\n\\', "fluid": {"density": 1000.0},
                          "body": [{"name": "left.fin é", "semi_axes": [1.0, 2.0, 3.0]}],
                          "start": {"rotation": {"left.fin é": [0.0, 0.0, 1.0]}}, "time": {"duration": 1, "steps": 2}})
    assert problem.bodies == ["left.fin é"]
    assert problem.name == 'a "fish"\n\\'


def test_changed_goes_key_by_key_and_none_removes(translation):
    changed = translation.changed(goal={"move": [1.0, "free", "free"]}, search={"seed": 5}, cost=None)
    assert changed.settings["goal"]["move"] == [1.0, "free", "free"]
    assert changed.settings["goal"]["turn"] == translation.settings["goal"]["turn"]
    assert changed.settings["search"] == {**translation.settings["search"], "seed": 5}
    assert "cost" not in changed.settings and "cost" in translation.settings


def test_a_wrong_file_is_told_with_file_line_column_and_key(tmp_path):
    path = tmp_path / "wrong.toml"
    text = (ROOT / "examples" / "translation.toml").read_text(encoding="utf-8")
    path.write_text(text.replace("steps = 1000", "steps = -3"), encoding="utf-8")
    line = 1 + text[:text.index("steps = 1000")].count("\n")
    with pytest.raises(lp.InputError) as raised:
        lp.load(path)
    error = raised.value
    assert isinstance(error, ValueError)
    assert (error.file, error.line, error.key) == (str(path), line, "time.steps")
    assert str(error) == f"{path}:{line}:{error.column}: time.steps: {error.message}"
    assert "-3" in error.message and "\n" not in str(error)


def test_a_wrong_dict_is_told_with_its_key_alone(translation):
    with pytest.raises(lp.InputError) as raised:
        translation.changed(time={"stepz": 3})
    assert raised.value.key == "time.stepz" and raised.value.file is None and raised.value.line is None
    assert str(raised.value).startswith("time.stepz: ") and '"steps"' in str(raised.value)
    for section, value, key in (("fluid", {"density": float("nan")}, "fluid.density"),
                                ("goal", {"move": [1.0, 2.0]}, "goal.move"),
                                ("body", [{"name": "a", "semi_axes": np.zeros(3)}], "body[0].semi_axes")):
        with pytest.raises(lp.InputError, match=key.replace("[", r"\[")):
            translation.changed(**{section: value})


def test_what_is_no_setting_is_a_type_error(translation):
    with pytest.raises(TypeError, match="object"):
        translation.changed(time={"steps": object()})
    with pytest.raises(TypeError, match="keys"):
        lp.Problem({1: 2})


def test_a_missing_file_is_not_found(tmp_path):
    with pytest.raises(FileNotFoundError, match="none.toml"):
        lp.load(tmp_path / "none.toml")
    with pytest.raises(FileNotFoundError, match="solution.json"):
        lp.load_solution(tmp_path)


def test_the_local_connection_moves_the_root_as_marches_do(root):
    problem = lp.load(root / "examples/translation.toml").changed(time={"steps": 400}, search={"starts": 1})
    solution = lp.solve(problem)
    k, h = 150, solution.time[1]
    found = problem.connection(solution.rotation[k])
    assert found["rates"] == [("front", 0), ("front", 1), ("front", 2), ("back", 0), ("back", 1), ("back", 2)]
    assert found["angular"].shape == found["linear"].shape == (3, 6) and found["inertia"].shape == (6, 6)
    assert np.allclose(found["inertia"], found["inertia"].T) and np.linalg.eigvalsh(found["inertia"])[0] > 0.0
    angle = solution.joint_angle  # of ball joints bent about one axis: the rates of these are those of the angle
    rates = ((angle[k + 1] - angle[k - 1]) / (2.0 * h)).ravel()
    linear = found["linear"] @ rates  # along the root's axes
    moved = (solution.position[k + 1] - solution.position[k - 1]) / (2.0 * h)
    assert np.abs(solution.rotation[k][0] @ linear - moved).max() < 1e-3 * np.abs(moved).max()
    turned = solution.rotation[k - 1][0].T @ solution.rotation[k + 1][0]
    turning = np.arctan2(turned[1, 0], turned[0, 0]) / (2.0 * h)
    assert abs((found["angular"] @ rates)[2] - turning) < 1e-3 * abs(turning)
    with pytest.raises(lp.InputError, match="rotation"):
        problem.connection(np.zeros((2, 3, 3)))


def test_a_check_is_what_the_command_line_prints(root):
    problem = lp.load(root / "examples/translation.toml")
    spline = problem.changed(control={"kind": "spline", "points": 5}, limits={"torque": 100.0})
    assert "Not for lamprey solve" in spline.check() and "Not for lamprey solve" not in problem.check()
    hinges = lp.load(root / "examples/hinge_fins.toml")
    name = hinges.joints[0]
    settings = hinges.settings
    settings["goal"] = {"move": [0.1, "free", "free"]}
    settings["limits"] = {"angle": {name: [0.5, 1.0]}}
    with pytest.raises(lp.InputError, match=rf"breaks this limit by .* rad, bent by .* rad.*change start\.angle\.{name}"):
        lp.Problem(settings).check()


def test_shapes_that_joints_do_not_allow_have_no_connection(root):
    problem = lp.load(root / "examples/three_links.toml")
    shape = np.stack([np.eye(3)] * 3)
    problem.connection(shape), problem.connection_curvature(shape)
    c, s = np.cos(0.2), np.sin(0.2)
    shape[2] = [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]
    for of in problem.connection, problem.connection_curvature:
        with pytest.raises(lp.InputError, match="rotation of tail: found tail turned by 0.2 rad beside what joint tail"):
            of(shape)


def test_the_curvature_is_that_of_height_functions(root):
    problem = lp.load(root / "examples/three_links.toml")
    heights = problem.height_functions("head", "tail", (-1.0, 1.0), (-0.8, 1.2), points=21)
    assert heights["normal"] == 2 and heights["linear"].shape == (2, 21, 21) and heights["angular"].shape == (21, 21)

    def about_z(angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    i, j = 4, 17
    shape = [np.eye(3), about_z(heights["first"][i]), about_z(heights["second"][j])]
    curvature = problem.connection_curvature(shape)
    assert curvature["rates"] == [("head", 0), ("tail", 0)]
    assert np.allclose(curvature["linear"], -curvature["linear"].transpose(0, 2, 1))
    turn, shift = curvature["angular"][2, 0, 1], curvature["linear"][:2, 0, 1]
    assert abs(heights["angular"][i, j] - turn) < 1e-12
    x, y = heights["frame_position"][:, i, j]
    seen = about_z(-heights["frame_angle"][i, j])[:2, :2] @ (shift + turn * np.array([-y, x]))
    assert np.abs(heights["linear"][:, i, j] - seen).max() < 1e-12


def test_height_functions_of_modes_are_those_of_angles_by_the_area_that_the_modes_span(root):
    problem = lp.load(root / "examples/three_links.toml")
    plain = problem.height_functions("head", "tail", (-0.5, 0.5), (-0.5, 0.5), points=5, middle={"head": 0.2})
    modes = problem.height_functions({"head": 1.0, "tail": 0.5}, {"head": -1.0, "tail": 1.0}, (-0.1, 0.1), (-0.2, 0.2),
                                     points=5, middle={"head": 0.2})
    assert abs(modes["angular"][2, 2] - 1.5 * plain["angular"][2, 2]) < 1e-12 and abs(plain["angular"][2, 2]) > 1e-5


def test_volumes_over_a_gaits_loop_are_what_it_moved(root):
    problem = lp.load(root / "examples/ellipses.toml").changed(search={"starts": 1})
    loop = lp.solve(problem).shape_loop()
    assert loop["variables"] == ("head", "tail") and loop["modes"] is None
    assert len(loop["first"]) == len(loop["second"]) == problem.steps + 1
    assert np.abs(loop["by_volume"] - loop["moved"]).max() < 0.01 * np.abs(loop["moved"]).max()
    assert loop["heights"]["linear"].shape == (2, 31, 31)
    still = lp.simulate(lp.load(root / "examples/translation.toml"), steps=4)
    assert still.shape_loop() is None


def test_height_functions_name_what_they_cannot_tell(root):
    problem = lp.load(root / "examples/three_links.toml")
    with pytest.raises(lp.InputError, match="allowed: head, tail"):
        problem.height_functions("nose", "tail", (-1, 1), (-1, 1))
    with pytest.raises(lp.InputError, match="first_range"):
        problem.height_functions("head", "tail", (1, -1), (-1, 1))
    with pytest.raises(lp.InputError, match="another one"):
        problem.height_functions("head", "head", (-1, 1), (-1, 1))
    with pytest.raises(lp.InputError, match="first: found int"):
        problem.height_functions(3, "tail", (-1, 1), (-1, 1))
    with pytest.raises(lp.InputError, match="middle: found str"):
        problem.height_functions("head", "tail", (-1, 1), (-1, 1), middle="head")
    with pytest.raises(lp.InputError, match="finite number"):
        problem.height_functions({"head": "much"}, "tail", (-1, 1), (-1, 1))
    balls = lp.load(root / "examples/translation.toml")
    with pytest.raises(lp.InputError, match="no axis"):
        balls.height_functions("front", "back", (-1, 1), (-1, 1))
    with pytest.raises(lp.InputError, match="otherwise than in one plane"):
        balls.height_functions(("front", 1), ("back", 2), (-1, 1), (-1, 1))


def test_passive_joints_move_as_they_do_where_their_angles_are_left_out(root):
    problem = lp.load(root / "examples/compliant_tail.toml")
    time = np.linspace(0.0, 0.8, 81)
    trunk = 0.4 * np.sin(7.0 * time) ** 2
    marched = lp.simulate(problem, angles=(time, np.stack([trunk, np.full_like(time, np.nan)], axis=1)), steps=80)
    assert marched.status == "simulated", marched.message
    assert np.abs(marched.joint_angle[:, 1, 0]).max() > 0.05 and np.abs(marched.control[:, 1]).max() == 0.0
    assert np.abs(marched.joint_angle[:, 0, 0] - trunk).max() < 1e-9
    with pytest.raises(lp.InputError, match="not finite"):
        lp.simulate(problem, angles=(time, np.stack([np.full_like(time, np.nan), trunk], axis=1)))


def test_problems_are_equal_where_their_settings_are():
    paths = [ROOT / "examples" / name for name in ("gait.toml", "hinge_fins.toml", "tumble.toml", "translation.toml")]
    problems = [lp.load(path) for path in paths]
    for problem in problems:
        again = lp.Problem(problem.settings)
        assert again == problem and not again != problem and hash(again) == hash(problem)
        other = problem.changed(time={"steps": problem.steps + 1})
        assert other != problem and other.changed(time={"steps": problem.steps}) == problem
        assert problem != problem.settings and problem != 1
    assert len(set(problems + [lp.load(path) for path in paths])) == len(paths)
    assert problems[0].changed(fluid={"density": 1}) == problems[0].changed(fluid={"density": 1.0})


def test_settings_will_do_wherever_a_problem_is_taken(translation):
    few = translation.changed(time={"steps": 20}, search={"starts": 1})
    march = lp.simulate(few.settings, steps=4)
    assert np.array_equal(march.position, lp.simulate(few, steps=4).position)
    solution = lp.solve(few.settings)
    assert solution.cost == lp.solve(few).cost
    assert lp.Solver(few.settings, solution).cost == solution.cost
    with pytest.raises(TypeError, match="allowed: a Problem, its settings as a dict, or the path"):
        lp.solve([few])
    with pytest.raises(lp.InputError, match="stepz"):
        lp.solve({**few.settings, "time": {"duration": 1.0, "stepz": 3}})


def test_a_matrix_in_the_place_of_numbers_is_told_to_be_one(translation):
    body = {**translation.settings["body"][0], "semi_axes": np.eye(3)}
    with pytest.raises(lp.InputError, match="write a plain number for each, in one pair of brackets") as raised:
        translation.changed(body=[body, *translation.settings["body"][1:]])
    assert raised.value.key == "body[0].semi_axes"


def test_messages_name_arguments_not_options_of_the_command_line(translation):
    few = translation.changed(time={"duration": 1.0, "steps": 20}, search={"starts": 1})
    still = np.zeros((5, 2, 3))
    with pytest.raises(lp.InputError, match=r"set a shorter duration=$"):
        lp.simulate(few, (np.linspace(0, 0.5, 5), still))
    march = lp.simulate(few, (np.linspace(0, 2.0, 5), still))
    assert "; duration=2 marches the whole." in march.message
    solution = lp.solve(few)
    assert "--" not in solution.message
    assert "(lamprey.solve(resolve=True) goes on to them by itself)" in solution.message
    with pytest.raises(lp.InputError, match='use solver="ipopt" for this problem') as raised:
        lp.solve(few.changed(control={"kind": "spline", "points": 5}), solver="newton")
    assert raised.value.key == "solver"
