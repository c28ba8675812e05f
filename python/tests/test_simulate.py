"""Marches: moments in every form that they may have, feedback, the ends that a march can come to."""
import pathlib
import re

import numpy as np
import pytest

import lamprey as lp
from motion import orthogonality, total_momentum

ROOT = pathlib.Path(__file__).parents[2]


def test_a_solutions_moments_march_to_its_end(translation, solution):
    marched = lp.simulate(translation, solution)
    assert type(marched) is lp.Trajectory and marched.status == "simulated" and marched.certificate is None
    assert np.abs(marched.rotation - solution.rotation).max() < 1e-11
    assert np.abs(marched.position - solution.position).max() < 1e-11


def test_moments_come_as_arrays_functions_and_files(translation, solution, tmp_path):
    axis = np.array([0.0, 0.0, 1.0])
    time = np.linspace(0.0, 1.0, 101)

    def moments(t):
        return np.array([40.0 * np.sin(6.0 * t) * axis, 25.0 * np.cos(4.0 * t) * axis])

    by_function = lp.simulate(translation, moments)
    control = np.array([moments(t) for t in time])
    by_array = lp.simulate(translation, (time, control))
    assert np.abs(by_function.control - control).max() < 1e-12
    assert np.abs(by_function.rotation - by_array.rotation).max() < 1e-12
    assert np.abs(by_function.rotation[-1] - by_function.rotation[0]).max() > 1e-3
    table = tmp_path / "controls.csv"
    table.write_text("\n".join(",".join(map(repr, [float(t), *map(float, u.ravel())])) for t, u in zip(time, control)))
    assert np.array_equal(lp.simulate(translation, table).rotation, by_array.rotation)
    solution.save(tmp_path / "run")
    assert np.array_equal(lp.simulate(translation, tmp_path / "run" / "solution.json").rotation,
                          lp.simulate(translation, solution).rotation)


def test_momentum_stays_and_rotations_stay_rotations(root):
    tumble = lp.simulate(root / "examples" / "tumble.toml", steps=400, duration=0.5)
    assert tumble.rotation.shape[0] == 401 and abs(tumble.time[-1] - 0.5) < 1e-15
    assert orthogonality(tumble.rotation) < 1e-12
    linear, angular = total_momentum(tumble)
    scale = np.abs(angular).max()
    assert scale > 1e-3
    assert np.abs(linear - linear[0]).max() < 1e-11 * scale and np.abs(angular - angular[0]).max() < 1e-11 * scale


def test_schemes_agree_at_their_order_and_the_reference_too(root):
    ends = {}
    for scheme in ("midpoint", "order4"):
        for steps in (100, 200):
            run = lp.simulate(root / "examples" / "tumble.toml", scheme=scheme, steps=steps, duration=0.5)
            ends[scheme, steps] = run.rotation[-1]
    exact = lp.simulate(root / "examples" / "tumble.toml", reference=True, steps=100, duration=0.5)
    assert exact.marched_by
    off = {key: np.abs(end - exact.rotation[-1]).max() for key, end in ends.items()}
    assert 3.5 < off["midpoint", 100] / off["midpoint", 200] < 4.5
    assert 10.0 < off["order4", 100] / off["order4", 200] < 22.0


def test_feedback_brings_a_disturbed_swimmer_home(translation, solution, tmp_path):
    # from turns that the gains answer
    followed = lp.simulate(translation, feedback=solution, perturb=1e-3, reference=True)
    alone = lp.simulate(translation, solution, perturb=1e-3, reference=True)
    assert followed.tracking["maneuver"] == translation.name
    off = [np.abs(run.rotation[-1] - solution.rotation[-1]).max() for run in (followed, alone)]
    assert off[0] < 0.2 * off[1]
    solution.save(tmp_path)
    assert np.array_equal(lp.simulate(translation, feedback=tmp_path, perturb=1e-3, reference=True).rotation, followed.rotation)


def test_a_gait_goes_on_for_several_cycles(root):
    problem = lp.load(root / "examples" / "gait.toml")
    gait = lp.solve(problem, refinement=False)
    shift = gait.position[-1] - gait.position[0]
    marched = lp.simulate(problem, feedback=gait, cycles=3)
    assert np.allclose(marched.position[-1] - marched.position[0], 3 * shift, atol=1e-6)
    with pytest.raises(lp.InputError, match="march without a stored motion"):
        lp.simulate(problem, cycles=3)


def test_columns_of_a_table_are_those_that_its_header_names(translation, tmp_path):
    table = tmp_path / "moments.csv"
    table.write_text("t,back z,back y,back x,front x,front y,front z\n0,3,0,0,0,0,1\n1,3,0,0,0,0,1\n")
    by_name = lp.simulate(translation, table)
    control = np.zeros((2, 2, 3))
    control[:, 1, 2] = 3  # joints: front, back
    control[:, 0, 2] = 1
    assert np.array_equal(by_name.rotation, lp.simulate(translation, ([0.0, 1.0], control)).rotation)
    table.write_text("t,a,b,c,d,e,f\n0,3,0,0,0,0,1\n1,3,0,0,0,0,1\n")
    with pytest.warns(UserWarning, match="names no joints"):
        lp.simulate(translation, table)


def test_a_march_that_does_not_get_on_is_stalled_with_the_nodes_before(root):
    run = lp.simulate(root / "examples" / "tumble.toml", scheme="order4", steps=1, duration=2.0)
    assert run.status == "stalled" and len(run.time) == 1 and run.message
    assert lp.simulate(root / "examples" / "tumble.toml", scheme="order4", steps=1, duration=2.0, adaptive=True).status == "simulated"


def test_what_a_function_raises_comes_out(translation):
    with pytest.raises(ZeroDivisionError):
        lp.simulate(translation, lambda t: 1 / 0)
    with pytest.raises(lp.InputError, match=r"controls\(0\).*\[2\]\[3\]"):
        lp.simulate(translation, lambda t: [[0.0, 1.0]])


@pytest.mark.parametrize("options, key", [
    ({"steps": 0}, "steps"), ({"duration": -1.0}, "duration"), ({"scheme": "euler"}, "scheme"), ({"perturb": 9.0}, "perturb"),
    ({"reference": True, "adaptive": True}, "reference"), ({"controls": ([0.0, 0.0], np.zeros((2, 2, 3)))}, "controls"),
    ({"controls": ([0.0, 1.0], np.zeros((2, 3, 3)))}, "controls"), ({"controls": ([0.0, "x"], 1.0)}, "controls[0]")])
def test_wrong_options_are_named(translation, options, key):
    with pytest.raises(lp.InputError) as raised:
        lp.simulate(translation, **options)
    assert raised.value.key == key


def test_joint_angles_turn_bodies_as_the_motion_does(root):
    march = lp.simulate(root / "examples" / "hinge_fins.toml", root / "examples" / "hinge_fins_controls.csv")
    demands = march.joint_demands()
    for j, joint in enumerate(march.problem["joints"]):
        parent, child = march.rotation[:, joint["parent"]], march.rotation[:, joint["child"]]
        angle = march.joint_angle[:, j, 0]
        turn = parent[0].T @ child[0]
        bent = np.einsum("kab,kac->kbc", parent, child)  # seen from the parent
        cosine = (np.einsum("kaa->k", np.einsum("ab,kac->kbc", turn, bent)) - 1.0) / 2.0
        assert np.abs(np.cos(angle - angle[0]) - cosine).max() < 1e-12
        assert np.abs(march.joint_angle[:, j, 1:]).max() == 0.0
        assert demands[j]["joint"] == joint["name"]
        assert demands[j]["angles"] == [(angle.min(), angle.max())]
        assert demands[j]["largest_moment"] == np.linalg.norm(march.control[:, j], axis=1).max() > 0.0


def loop(t):
    return 0.7 * np.array([np.cos(2.0 * np.pi * t), np.sin(2.0 * np.pi * t)])


def test_joint_angles_are_followed_in_every_form(three_links, tmp_path):
    time = np.linspace(0.0, 1.0, 201)
    by_function = lp.simulate(three_links, angles=loop, steps=200, duration=1.0)
    assert by_function.status == "simulated" and by_function.certificate is None
    assert np.abs(by_function.joint_angle[:, :, 0] - [loop(t) for t in time]).max() < 1e-12
    assert np.linalg.norm(by_function.position[-1] - by_function.position[0]) > 1e-3
    linear, angular = total_momentum(by_function)
    assert max(np.abs(linear).max(), np.abs(angular).max()) < 1e-11
    rows = np.array([loop(t) for t in time])
    by_array = lp.simulate(three_links, angles=(time, rows), steps=200, duration=1.0)
    in_full = np.concatenate([rows[:, :, None], np.zeros((201, 2, 2))], axis=2)
    table = tmp_path / "angles.csv"
    lines = [f"{t!r},{float(np.degrees(b))!r},{a!r}" for t, (a, b) in zip(time.tolist(), rows.tolist())]
    table.write_text("\n".join(["t,tail (deg),head (rad)", *lines]))
    for angles in (in_full, by_array, table):
        same = lp.simulate(three_links, angles=(time, angles) if angles is in_full else angles, steps=200, duration=1.0)
        assert np.abs(same.position - by_function.position).max() < 1e-10
    again = lp.certify(by_array)
    assert again.status == "simulated" and again.certificate["equation_residual"] < 1e-10


def test_moments_of_hinges_are_numbers_about_their_axes(three_links):
    swung = lp.simulate(three_links, angles=loop, steps=200, duration=1.0)
    along = swung.control[:, :, 2]  # both axes are e_3
    assert np.abs(swung.control[:, :, :2]).max() < 1e-12 < np.abs(along).max()
    begin = dict(steps=200, duration=1.0)
    in_full = lp.simulate(three_links, controls=(swung.time, swung.control), **begin)
    by_rows = lp.simulate(three_links, controls=(swung.time, along), **begin)
    assert np.abs(by_rows.joint_angle - in_full.joint_angle).max() < 1e-12

    def pull(t):
        return np.array([0.1 * np.sin(t), -0.2 * np.cos(t)])

    by_function = lp.simulate(three_links, controls=pull, **begin)
    same = lp.simulate(three_links, controls=lambda t: np.stack([[0.0, 0.0, each] for each in pull(t)]), **begin)
    assert np.abs(by_function.joint_angle - same.joint_angle).max() < 1e-12 < np.ptp(same.joint_angle)
    with pytest.raises(lp.InputError, match=r"moments \(rows, 2, 3\) or \(rows, 2\)"):
        lp.simulate(three_links, controls=(swung.time, along[:, :1]))


def test_fixed_joints_have_no_numbers_beside_those_of_hinges(tmp_path):
    text = (ROOT / "examples" / "three_links.toml").read_text(encoding="utf-8")
    body, joint = text.index("[[body]]"), text.index("[[joint]]")
    name = re.search(r'name = "(\w+)"', text[body:]).group(1)
    keel = '[[body]]\nname = "keel"\nsemi_axes = [0.02, 0.02, 0.02]\n\n'
    held = (f'[[joint]]\nkind = "fixed"\nparent = "{name}"\nchild = "keel"\nparent_offset = [0.0, 0.0, -0.1]\n'
            'child_offset = [0.0, 0.0, 0.05]\n\n')
    path = tmp_path / "keeled.toml"
    path.write_text(text[:joint] + keel + held + text[joint:], encoding="utf-8")
    keeled = lp.load(path)
    time = np.linspace(0.0, 1.0, 41)
    angles = np.stack([0.3 * np.sin(time), 0.2 * np.sin(2.0 * time)], axis=1)
    by_numbers = lp.simulate(keeled, angles=(time, angles), steps=100, duration=1.0)
    assert by_numbers.joint_angle.shape[1] == 3
    in_full = np.zeros((41, 3, 3))
    in_full[:, 1:, 0] = angles
    same = lp.simulate(keeled, angles=(time, in_full), steps=100, duration=1.0)
    assert np.abs(by_numbers.position - same.position).max() < 1e-12 < np.ptp(same.position)
    with pytest.raises(lp.InputError, match=r"angles \(rows, 3, 3\) or \(rows, 2\)"):
        lp.simulate(keeled, angles=(time, in_full[:, :, 0]), steps=100, duration=1.0)


def test_inertia_may_differ_from_the_problems(translation):
    plain = lp.simulate(translation)
    heavier = lp.simulate(translation, perturb_inertia=0.1, seed=3)
    factors = [b["mass_matrix"][0][0] / a["mass_matrix"][0][0]
               for a, b in zip(plain.problem["bodies"], heavier.problem["bodies"])]
    assert all(1e-4 < abs(factor - 1.0) <= 0.1 for factor in factors) and len(set(factors)) == 3
    with pytest.raises(lp.InputError, match="perturb_inertia: found 1"):
        lp.simulate(translation, perturb_inertia=1.0)


def test_loops_of_angles_repeat_and_move_the_swimmer_alike_each_time(three_links):
    time = np.linspace(0.0, 1.0, 101)
    rows = np.array([loop(t) for t in time])
    once = lp.simulate(three_links, angles=(time, rows), steps=100, duration=1.0)
    often = lp.simulate(three_links, angles=(time, rows), cycles=4, steps=400)
    assert abs(often.time[-1] - 4.0) < 1e-12
    assert np.abs(often.position[-1] - 4.0 * once.position[-1]).max() < 1e-4 * np.abs(once.position[-1]).max()
    for duration in ({}, {"duration": 4.0}):  # of all cycles together
        by_function = lp.simulate(three_links, angles=loop, cycles=4, steps=400, **duration)
        assert np.abs(by_function.position[-1] - often.position[-1]).max() < 1e-6
    of_problem = three_links.changed(time={"steps": 100, "duration": 1.0})  # as many steps in each cycle
    by_default = lp.simulate(of_problem, angles=loop, cycles=4)
    assert len(by_default.time) == 401
    assert np.abs(by_default.position[-1] - often.position[-1]).max() < 1e-9
    with pytest.raises(lp.InputError, match="found 4 in 402 steps; allowed: as many steps in each cycle"):
        lp.simulate(three_links, angles=loop, cycles=4, steps=402)
    with pytest.raises(lp.InputError, match="between its last and its first angle"):
        lp.simulate(three_links, angles=loop, cycles=4, steps=400, duration=3.0)
    with pytest.raises(lp.InputError, match="between its last and its first angle"):
        lp.simulate(three_links, angles=(time, rows * (1.0 + time[:, None])), cycles=2)


def test_angles_that_cannot_be_followed_are_refused(three_links):
    for wrong, words in (({"scheme": "order4"}, "paper, trapezoid, midpoint"), ({"controls": loop}, "beside controls"),
                         ({"adaptive": True}, "leave them out"), ({"duration": 1.5}, None)):
        if words is None:
            with pytest.raises(lp.InputError, match="found angles from 0 s to 1 s"):
                lp.simulate(three_links, angles=([0.0, 1.0], np.zeros((2, 2))), **wrong)
        else:
            with pytest.raises(lp.InputError, match=words):
                lp.simulate(three_links, angles=loop, **wrong)
    in_z = np.zeros((2, 2, 3))
    in_z[:, :, 2] = 0.5  # a rotation vector, where a hinge's angle stands first
    with pytest.raises(lp.InputError, match=r"found \[0, 0, 0.5\] at 0 s; allowed: one angle of a hinge"):
        lp.simulate(three_links, angles=([0.0, 1.0], in_z))
    with pytest.raises(lp.InputError, match=r"angles\(0\)|angles\(0.0\)"):
        lp.simulate(three_links, angles=lambda t: [1.0, 2.0, 3.0])
    with pytest.raises(lp.InputError, match=r"allowed: time \(rows,\), angles \(rows, 2, 3\) or \(rows, 2\)"):
        lp.simulate(three_links, angles=([0.0, 1.0], np.zeros((2, 3))))
