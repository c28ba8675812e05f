#!/usr/bin/env python3
"""Writes malformed/*.toml: each is valid.toml with one rule broken, and begins with a line that says what the reader must answer:

    # expect: LINE: KEY: fragment | fragment | fragment

LINE is found here by looking for the marked text in the edited file, independently of the reader.

usage: make_malformed.py          (writes beside itself)
"""
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
VALID = (HERE / "valid.toml").read_text(encoding="utf-8")

BODIES = VALID[VALID.index("[[body]]"):VALID.index("[[joint]]")]
GOAL = VALID[VALID.index("[goal]"):VALID.index("[time]")]
LIMITS = VALID[VALID.index("[limits]"):VALID.index("[search]")]
FREE = "duration = \"free\"\nmin = 0.5\nmax = 2.5"
BACK_START = "rotation.back = [0.0, 0.0, 0.75]"
ELLIPSES = [(f"semi_axes = [{three}]", f"semi_axes = [{two}]") for three, two in
            (("8.0, 1.5, 2.0", "8.0, 1.5"), ("5.0, 0.8, 1.5", "5.0, 0.8"), ("5, 0.8, 1.5", "5, 0.8"), ("2.0, 0.8, 1.5", "2.0, 0.8"))]
# name: (old text, new text (or a list of such pairs, None), text of the expected line, key, fragments: found, allowed, cure)
CASES = {
    "schema_missing": ("schema = 1\n", "", "# expect", "schema", ["found nothing", "schema = 1", "add this key"]),
    "schema_newer": ("schema = 1", "schema = 2", "schema = 2", "schema", ["found 2", "the whole number 1", "choose"]),
    "section_unknown": ("[integrator]", "[integrater]", "[integrater]", "integrater", ["unknown key", "integrator, limits", "nearest known key is \"integrator\""]),
    "key_unknown": ("semi_axes = [8.0", "semi_axis = [8.0", "semi_axis", "body[0].semi_axis", ["unknown key", "semi_axes", "nearest known key is \"semi_axes\""]),
    "name_is_a_number": ("name = \"Every key\"", "name = 7", "name = 7", "name", ["found 7", "a text", "double quotes"]),
    "density_missing": ("density = 0.01\n", "", "[fluid]", "fluid.density", ["found nothing", "≥ 0 (kg/m³), 0 for a vacuum", "add this key"]),
    "density_negative": ("density = 0.01", "density = -0.01", "density", "fluid.density", ["found -0.01", "a number ≥ 0 (kg/m³)", "choose a finite value"]),
    "density_next_to_nothing": ("density = 0.01", "density = 1e-100", "density", "fluid.density", ["found 1e-100", "between 1e-60 and 1e+60", "check the units"]),
    "density_infinite": ("density = 0.01", "density = inf", "density", "fluid.density", ["found inf", "≥ 0 (kg/m³)", "finite"]),
    "density_is_a_text": ("density = 0.01", "density = \"0.01\"", "density", "fluid.density", ["found \"0.01\"", "a number", "without quotes"]),
    "body_name_missing": ("name = \"front\"\n", "", "[[body]]#2", "body[1].name", ["found nothing", "unique", "add this key"]),
    "body_name_empty": ("name = \"front\"\n", "name = \"\"\n", "name = \"\"", "body[1].name", ["found \"\"", "not empty", "name it"]),
    "body_name_twice": ("name = \"back\"\n", "name = \"front\"\n", "name = \"front\"#2", "body[2].name", ["found \"front\" a second time", "differ", "rename"]),
    "semi_axes_missing": ("semi_axes = [5.0, 0.8, 1.5]\n", "", "[[body]]#2", "body[1].semi_axes", ["found nothing", "three numbers > 0 (m)", "add this key"]),
    "semi_axes_negative": ("[5.0, 0.8, 1.5]", "[5.0, -0.8, 1.5]", "[5.0, -0.8", "body[1].semi_axes", ["found [5, -0.8, 1.5]", "three numbers > 0 (m)", "choose"]),
    "semi_axes_zero": ("[5.0, 0.8, 1.5]", "[5.0, 0, 1.5]", "[5.0, 0,", "body[1].semi_axes", ["found [5, 0, 1.5]", "three numbers > 0 (m)", "choose"]),
    "semi_axes_too_few": ("[5.0, 0.8, 1.5]", "[5.0]", "[5.0]", "body[1].semi_axes", ["found [5]", "three numbers > 0 (m), or two of an ellipse", "write three"]),
    "semi_axes_of_two_kinds": ("[5.0, 0.8, 1.5]", "[5.0, 0.8]", "[5.0, 0.8]", "body[1].semi_axes", ["two numbers beside bodies of three", "two for every body (ellipses in the plane) or three", "add the third number here"]),
    "ellipse_negative": ("[5.0, 0.8, 1.5]", "[5.0, -0.8]", "[5.0, -0.8]", "body[1].semi_axes", ["found [5, -0.8]", "two numbers > 0 (m)", "choose a finite value"]),
    "ellipses_on_a_ball_joint": (ELLIPSES, None, "kind = \"ball\"", "joint[0].kind", ["a ball joint", "hinge or fixed between ellipses", "kind = \"hinge\""]),
    "semi_axes_not_a_number": ("[5.0, 0.8, 1.5]", "[5.0, nan, 1.5]", "[5.0, nan", "body[1].semi_axes", ["found [5, nan, 1.5]", "three numbers > 0 (m)", "finite"]),
    "semi_axes_in_brackets": ("[5.0, 0.8, 1.5]", "[[5.0, 0.8, 1.5], [1.0, 1.0, 1.0], [1.0, 1.0, 1.0]]", "[[5.0, 0.8, 1.5]", "body[1].semi_axes", ["found [[5, 0.8, 1.5]", "three numbers > 0 (m)", "write a plain number for each, in one pair of brackets"]),
    "semi_axes_astronomic": ("[5.0, 0.8, 1.5]", "[5e200, 5e200, 1.5]", "[5e200", "body[1].semi_axes", ["found [5e+200", "between 1e-60 and 1e+60", "check the units"]),
    "semi_axes_whose_inertia_overflows": ([("density = 0.01", "density = 1e60"), ("[5.0, 0.8, 1.5]", "[1e60, 1e60, 1e60]")], None, "[1e60", "body[1].semi_axes", ["kg", "ordinary numbers", "check the units"]),
    "duration_next_to_nothing": ("min = 0.5", "min = 1e-308", "min = 1e-308", "time.min", ["found 1e-308", "between 1e-60 and 1e+60", "check the units"]),
    "semi_axes_far_apart": ("[5.0, 0.8, 1.5]", "[5.0, 0.8, 1e-60]", "[5.0, 0.8, 1e-60]", "body[1].semi_axes", ["found [5, 0.8, 1e-60]", "a factor of 1e50 at most", "check the units"]),
    "vacuum_without_mass": ("density = 0.01", "density = 0", "[[body]]#2", "body[1].mass", ["found nothing in a vacuum", "a number > 0 (kg)", "add this key"]),
    "mass_zero": ("mass = 1.0", "mass = 0", "mass = 0", "body[0].mass", ["found 0", "a number > 0 (kg)", "choose"]),
    "body_inertia_impossible": ("[1.25, 13.6, 13.25]", "[1.25, 15.6, 13.25]", "body_inertia", "body[0].body_inertia", ["15.6", "up to the sum of the other two", "inertia_matrix"]),
    "body_inertia_negative": ("[1.25, 13.6, 13.25]", "[-1.25, 13.6, 13.25]", "body_inertia", "body[0].body_inertia", ["-1.25", "symmetric positive definite", "eigenvalues"]),
    "mass_matrix_too_long": ("[1.0659, 2.1696, 1.6641]", "[1.0659, 2.1696, 1.6641, 1.0]", "mass_matrix", "body[0].mass_matrix", ["1.6641, 1]", "three rows of three", "as in"]),
    "inertia_matrix_not_symmetric": ("[0.1, 20.15, 0.2]", "[0.2, 20.15, 0.2]", "inertia_matrix", "body[0].inertia_matrix", ["[0.2, 20.15, 0.2]", "symmetric positive definite", "mirror image"]),
    "inertia_matrix_not_positive": ("[0.1, 20.15, 0.2], [0.0, 0.2, 25.3276]", "[0.1, 20.15, 30.0], [0.0, 30.0, 25.3276]", "inertia_matrix", "body[0].inertia_matrix", ["[0.1, 20.15, 30]", "symmetric positive definite", "eigenvalues"]),
    "inertia_matrix_ragged": ("[0.1, 20.15, 0.2]", "[0.1, 20.15]", "inertia_matrix", "body[0].inertia_matrix", ["found [0.1, 20.15]", "three numbers", "write three"]),
    "coupling_matrix_too_large": ("[0.2, 0.0, 0.0], [0.0, 0.0, -0.3]", "[2.0, 0.0, 0.0], [0.0, 0.0, -0.3]", "coupling_matrix", "body[0].coupling_matrix", ["[2, 0, 0]", "[J Cᵀ; C M] is positive definite", "smaller"]),
    "coupling_matrix_ragged": ("[0.2, 0.0, 0.0], [0.0, 0.0, -0.3]", "[0.2, 0.0], [0.0, 0.0, -0.3]", "coupling_matrix", "body[0].coupling_matrix", ["found [0.2, 0]", "three numbers", "write three"]),
    "joint_kind_unknown": ("kind = \"hinge\"", "kind = \"hing\"", "kind = \"hing\"", "joint[1].kind", ["found \"hing\"", "\"universal\" or \"hinge\"", "nearest is \"hinge\""]),
    "joint_parent_missing": ("parent = \"back\"\n", "", "[[joint]]#3", "joint[2].parent", ["found nothing", "name of a body", "add this key"]),
    "joint_parent_unknown": ("parent = \"back\"", "parent = \"bakc\"", "parent = \"bakc\"", "joint[2].parent", ["found \"bakc\"", "name of a [[body]]", "nearest is \"back\""]),
    "joint_child_unknown": ("child = \"tail\"", "child = \"tall\"", "child = \"tall\"", "joint[2].child", ["found \"tall\"", "name of a [[body]]", "nearest is \"tail\""]),
    "joint_to_itself": ("parent = \"back\"", "parent = \"tail\"", "child = \"tail\"", "joint[2].child", ["own parent", "another body", "name the other"]),
    "joint_moves_the_root": ("child = \"tail\"", "child = \"middle\"", "child = \"middle\"", "joint[2].child", ["found \"middle\", the root", "any body but the first", "exchange parent and child"]),
    "joint_second_parent": ("child = \"tail\"", "child = \"front\"", "child = \"front\"#2", "joint[2].child", ["\"front\" with a second parent, \"back\"", "one parent", "remove this joint or the one with \"middle\""]),
    "joint_cycle": ("parent = \"middle\"\nchild = \"back\"", "parent = \"tail\"\nchild = \"back\"", "child = \"back\"", "joint[1].child", ["a cycle", "a tree", "remove one"]),
    "body_out_of_reach": ("[[body]]\nname = \"tail\"", "[[body]]\nname = \"stray\"\nsemi_axes = [1.0, 1.0, 1.0]\n\n[[body]]\nname = \"tail\"", "name = \"stray\"", "body[3].name", ["found \"stray\"", "one tree", "child = \"stray\""]),
    "joint_kind_of_another_program": ("kind = \"hinge\"", "kind = \"revolute\"", "kind = \"revolute\"", "joint[1].kind", ["found \"revolute\"", "\"universal\" or \"hinge\"", "\"revolute\" is called \"hinge\" here"]),
    "joint_that_slides": ("kind = \"hinge\"", "kind = \"prismatic\"", "kind = \"prismatic\"", "joint[1].kind", ["found \"prismatic\"", "\"universal\" or \"hinge\"", "joints turn here, none slides"]),
    "joint_name_twice": ("kind = \"hinge\"", "kind = \"hinge\"\nname = \"neck\"", "name = \"neck\"#2", "joint[1].name", ["\"neck\" a second time", "differ", "another name"]),
    "joint_offset_missing": ("child_offset = [5.5, 0.0, 0.0]\n", "", "[[joint]]#2", "joint[1].child_offset", ["found nothing", "three numbers", "add this key"]),
    "joint_offset_a_number": ("child_offset = [5.5, 0.0, 0.0]", "child_offset = 5.5", "child_offset = 5.5", "joint[1].child_offset", ["found 5.5", "three numbers", "in brackets"]),
    "axis_on_a_ball": ("stiffness = 2.0", "axis = [0, 0, 1]\nstiffness = 2.0", "axis = [0, 0, 1]", "joint[0].axis", ["this key on a ball joint", "on a hinge only", "remove it"]),
    "stiffness_on_a_fixed_joint": ([("kind = \"hinge\"", "kind = \"fixed\"\nstiffness = 1.0"), ("axis = [0.0, 0.0, 2.0]\n", "")], None, "stiffness = 1.0", "joint[1].stiffness", ["on a fixed joint", "ball, universal and hinge", "remove it"]),
    "angle_of_a_fixed_joint": ([("kind = \"hinge\"", "kind = \"fixed\""), ("axis = [0.0, 0.0, 2.0]\n", ""), ("rotation.back = [0.0, 0.0, 0.75]", "rotation.back = [0.0, 0.0, 0.25]"), ("angular_velocity.back = [0.0, 0.0, 0.75]", "angular_velocity.back = [0.0, 0.0, 0.5]")], None, "angle.back", "limits.angle.back", ["a limit on a fixed joint", "on joints that move", "remove it"]),
    "hinge_without_axis": ("axis = [0.0, 0.0, 2.0]\n", "", "[[joint]]#2", "joint[1].axis", ["found nothing on a hinge", "the free axis", "add this key"]),
    "hinge_axis_zero": ("axis = [0.0, 0.0, 2.0]", "axis = [0.0, 0.0, 0.0]", "axis = [0.0, 0.0, 0.0]", "joint[1].axis", ["found [0, 0, 0]", "not zero", "as in"]),
    "axes_not_orthogonal": ("axes = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]", "axes = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]]", "axes = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]]", "joint[2].axes", ["found axes at 0.785", "orthogonal at zero angle", "turn one"]),
    "axes_one_only": ("axes = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]", "axes = [[0.0, 0.0, 1.0]]", "axes = [[0.0, 0.0, 1.0]]", "joint[2].axes", ["found [[0, 0, 1]]", "two vectors", "give two"]),
    "control_axes_dependent": ("[[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]]", "[[0.0, 1.0, 1.0], [0.0, -2.0, -2.0]]", "control_axes", "joint[0].control_axes", ["found [[0, 1, 1], [0, -2, -2]]", "linearly independent", "remove"]),
    "control_axes_zero": ("[[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]]", "[[0.0, 0.0, 0.0]]", "control_axes", "joint[0].control_axes", ["found [[0, 0, 0]]", "non-zero", "remove"]),
    "control_axes_none": ("[[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]]", "[]", "control_axes", "joint[0].control_axes", ["found []", "at least one vector", "actuated = false"]),
    "control_axes_flat": ("[[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]]", "[0.0, 0.0, 1.0]", "control_axes", "joint[0].control_axes", ["found [0, 0, 1]", "a list of vectors", "double brackets"]),
    "control_axes_not_actuated": ("actuated = false", "actuated = false\ncontrol_axes = [[0, 0, 1]]", "control_axes = [[0, 0, 1]]", "joint[1].control_axes", ["actuated = false", "only on actuated joints", "remove one"]),
    "actuated_a_number": ("actuated = false", "actuated = 0", "actuated = 0", "joint[1].actuated", ["found 0", "true or false", "without quotes"]),
    "damping_negative": ("damping = 0.5", "damping = -0.5", "damping", "joint[0].damping", ["found -0.5", "≥ 0 (N m s/rad)", "choose"]),
    "start_body_unknown": ("rotation.middle = [0.0, 0.0, 0.25]", "rotation.midle = [0.0, 0.0, 0.25]", "rotation.midle", "start.rotation.midle", ["unknown key", "middle, front", "nearest known key is \"middle\""]),
    "start_rotation_without_body": ("rotation.middle = [0.0, 0.0, 0.25]\nrotation.back = [0.0, 0.0, 0.75]\nrotation.tail = [0.0, 0.0, 0.75]", "rotation = [0.0, 0.0, 0.25]", "rotation = [0.0, 0.0, 0.25]", "start.rotation", ["found [0, 0, 0.25]", "a table", "[start.rotation]"]),
    "start_rotation_breaks_hinge": (BACK_START, "rotation.back = [0.0, 0.5, 0.75]", "rotation.back = [0.0, 0.5", "start.rotation.back", ["outside what the hinge joint \"back\" allows", "fit the joints", "reference_rotation"]),
    "start_rotation_breaks_universal": ("rotation.tail = [0.0, 0.0, 0.75]", "rotation.tail = [0.4, 0.0, 0.75]", "rotation.tail = [0.4", "start.rotation.tail", ["outside what the universal joint \"tail\" allows", "fit the joints", "turn this body"]),
    "start_velocity_breaks_hinge": ("angular_velocity.back = [0.0, 0.0, 0.75]", "angular_velocity.back = [0.25, 0.0, 0.75]", "angular_velocity.back", "start.angular_velocity.back", ["found [0.25, 0, 0.75], 0.25 rad/s outside what the hinge joint \"back\" allows", "\"middle\" seen from this body plus any turn about its axis [0, 0, 2]", "remove this key to move with the parent, or write the nearest one, [0, 0, 0.75]"]),
    "start_velocity_breaks_universal": ("angular_velocity.back = [0.0, 0.0, 0.75]", "angular_velocity.back = [0.0, 0.0, 0.75]\nangular_velocity.tail = [0.5, 0.25, 0.0]", "angular_velocity.tail", "start.angular_velocity.tail", ["0.5 rad/s outside what the universal joint \"tail\" allows", "any turns about its axes [0, 0, 1] (parent's frame) and [0, 1, 0] (child's frame)", "the nearest one, [0, 0.25, 0]"]),
    "start_velocity_breaks_fixed": ([("kind = \"hinge\"", "kind = \"fixed\""), ("axis = [0.0, 0.0, 2.0]\n", ""), ("rotation.middle = [0.0, 0.0, 0.25]\nrotation.back = [0.0, 0.0, 0.75]\nrotation.tail = [0.0, 0.0, 0.75]\n", "")], None, "angular_velocity.back", "start.angular_velocity.back", ["found [0, 0, 0.75], 0.25 rad/s outside what the fixed joint \"back\" allows", "allowed: the angular velocity of \"middle\" seen from this body;", "nearest one, [0, 0, 0.5]"]),
    "turn_of_gait_twice": ("rotation.middle = [0.0, 0.0, 0.75]", "rotation.middle = [0.0, 0.0, 0.7]", "rotation.middle = [0.0, 0.0, 0.7]", "goal.rotation.middle", ["0.05 rad beside goal.turn in a periodic goal", "the rotation that goal.turn leads to", "remove this key"]),
    "end_of_a_child_of_a_gait": ("rotation.front = \"free\"", "rotation.front = [0.0, 0.0, 0.75]", "rotation.front", "goal.rotation.front", ["the end of a body that a joint leads, in a periodic goal", "the rotation of the root", "say where the root ends"]),
    "free_shape_not_periodic": ("periodic = true\n", "", "free_shape", "start.free_shape", ["true without a periodic goal", "only with goal.periodic", "remove it"]),
    "goal_body_unknown": ("rotation.front = \"free\"", "rotation.fronk = \"free\"", "rotation.fronk", "goal.rotation.fronk", ["unknown key", "middle, front", "nearest known key is \"front\""]),
    "goal_angle_of_a_gait": ("rotation.front = \"free\"", "angle.back = 0.1", "angle.back", "goal.angle", ["it with goal.periodic = true", "one of the two", "that at its start"]),
    "goal_angle_of_no_joint": ("rotation.front = \"free\"", "angle.nek = [0.1, 0.0, 0.0]", "angle.nek", "goal.angle.nek", ["unknown key", "neck, back, tail", "nearest known key is \"neck\""]),
    "goal_angle_beside_rotation": ("rotation.front = \"free\"", "rotation.front = \"free\"\nangle.neck = [0.1, 0.0, 0.0]", "angle.neck", "goal.angle.neck", ["it beside goal.rotation.front", "one of the two", "remove one"]),
    "goal_angles_too_few": ("rotation.front = \"free\"", "angle.tail = 0.1", "angle.tail", "goal.angle.tail", ["found 0.1", "two numbers (rad), one about each axis", "as in [0.1, 0.0]"]),
    "goal_shape_unknown": ("rotation.front = \"free\"", "shape = \"begin\"", "shape = \"begin\"", "goal.shape", ["found \"begin\"", "\"start\" or \"free\"", "the nearest is"]),
    "goal_shape_of_a_gait": ("rotation.front = \"free\"", "shape = \"start\"", "shape = \"start\"", "goal.shape", ["it with goal.periodic = true", "one of the two", "remove it"]),
    "goal_word_unknown": ("rotation.front = \"free\"", "rotation.front = \"fre\"", "rotation.front", "goal.rotation.front", ["found \"fre\"", "\"free\"", "write a rotation vector"]),
    "move_word_unknown": ("[2.0, \"free\", -1]", "[2.0, \"fre\", -1]", "move", "goal.move", ["found [2, \"fre\", -1]", "three entries, each a number (m) or \"free\"", "write a number"]),
    "move_too_short": ("[2.0, \"free\", -1]", "[2.0]", "move", "goal.move", ["found [2]", "three entries", "as in [2.0"]),
    "goal_breaks_hinge": ("rotation.middle = [0.0, 0.0, 0.75]", "rotation.middle = [0.3, 0.0, 0.75]", "rotation.middle = [0.3", "goal.rotation.middle", ["outside what the hinge joint \"back\" allows", "fit the joints", "\"free\""]),
    "goal_breaks_period": ("free_shape = true\n\n[goal]\nmove = [2.0, \"free\", -1]\nturn = [0.0, 0.0, 0.5]\nrotation.middle = [0.0, 0.0, 0.75]", "\n[goal]\nmove = [2.0, \"free\", -1]\nturn = [0.0, 0.0, 0.5]\nrotation.middle = [0.0, 0.0, 0.5]", "rotation.middle = [0.0, 0.0, 0.5]", "goal.rotation.middle", ["change joint \"back\" by 0.2", "start's shape", "remove periodic"]),
    "duration_missing": ("duration = \"free\"\n", "", "[time]", "time.duration", ["found nothing", "> 0 (s) or \"free\"", "add this key"]),
    "duration_zero": ("duration = \"free\"\nmin = 0.5\nmax = 2.5", "duration = 0.0", "duration = 0.0", "time.duration", ["found 0", "> 0 (s)", "choose"]),
    "duration_word_unknown": ("duration = \"free\"", "duration = \"Free\"", "duration", "time.duration", ["found \"Free\"", "or \"free\"", "write seconds"]),
    "duration_free_without_max": ("max = 2.5\n", "", "[time]", "time.max", ["found nothing", "with duration = \"free\"", "add this key"]),
    "duration_min_above_max": ("min = 0.5", "min = 3.5", "min = 3.5", "time.min", ["found 3.5 above max = 2.5", "min ≤ max", "exchange"]),
    "duration_fixed_with_min": ("duration = \"free\"", "duration = 1.0", "min = 0.5", "time.min", ["found 0.5", "only with duration = \"free\"", "remove it"]),
    "steps_zero": ("steps = 100", "steps = 0", "steps", "time.steps", ["found 0", "from 1 to 10000000", "choose"]),
    "steps_too_many": ("steps = 100", "steps = 10_000_001", "steps", "time.steps", ["found 10000001", "from 1 to 10000000", "choose"]),
    "steps_with_a_point": ("steps = 100", "steps = 100.0", "steps", "time.steps", ["found 100.0;", "a whole number", "decimal point"]),
    "steps_fractional": ("steps = 100", "steps = 100.5", "steps", "time.steps", ["found 100.5", "a whole number", "decimal point"]),
    "effort_zero": ("effort = 0.5", "effort = 0.0", "effort", "cost.effort", ["found 0", "> 0 (weight, however small)", "choose"]),
    "rule_unknown": ("rule = \"rectangle\"", "rule = \"simpson\"", "rule", "cost.rule", ["found \"simpson\"", "\"trapezoid\" or \"rectangle\"", "nearest"]),
    "rule_with_order4": ("scheme = \"midpoint\"", "scheme = \"order4\"", "rule", "cost.rule", ["\"rectangle\" with scheme \"order4\"", "no rule above order 2", "remove"]),
    "scheme_unknown": ("scheme = \"midpoint\"", "scheme = \"order5\"", "scheme =", "integrator.scheme", ["found \"order5\"", "\"order4\" or \"order6\"", "nearest is \"order"]),
    "scheme_cut_short": ("scheme = \"midpoint\"", "scheme = \"trapez\"", "scheme =", "integrator.scheme", ["found \"trapez\"", "\"order4\" or \"order6\"", "nearest is \"trapezoid\""]),
    "points_missing": ("points = 21\n", "", "[control]", "control.points", ["found nothing with kind = \"spline\"", "from 2 to steps + 1", "add this key"]),
    "points_one": ("points = 21", "points = 1", "points", "control.points", ["found 1", "from 2 to", "choose"]),
    "points_too_many": ("points = 21", "points = 102", "points", "control.points", ["found 102 with 100 steps", "steps + 1 = 101", "fewer points or more steps"]),
    "points_with_steps": ("kind = \"spline\"", "kind = \"steps\"", "points", "control.points", ["found 21 with kind = \"steps\"", "only with kind = \"spline\"", "remove it"]),
    "torque_negative": ("torque.neck = 1500.0", "torque = -1500.0", "torque", "limits.torque", ["found -1500", "> 0 (N m)", "choose"]),
    "torque_of_a_passive_joint": ("torque.neck", "torque.back", "torque.back", "limits.torque.back", ["a limit on a joint with actuated = false", "joints that exert moments", "remove it"]),
    "limit_cut_short": ("angular_velocity.back = 12.0", "velocity.back = 12.0", "velocity.back", "limits.velocity", ["unknown key", "angular_velocity", "nearest known key is \"angular_velocity\""]),
    "torque_joint_unknown": ("torque.neck", "torque.nec", "torque.nec", "limits.torque.nec", ["unknown key", "neck, back, tail", "nearest known key is \"neck\""]),
    "torque_of_a_body": ("torque.neck", "torque.front", "torque.front", "limits.torque.front", ["found a body", "joints: neck, back, tail", "write neck, the joint that leads it"]),
    "swing_too_large": ("swing.neck = 1.0", "swing.neck = 100.0", "swing.neck", "limits.swing.neck", ["found 100", "> 0 and ≤ 3.14159", "write radians"]),
    "turn_in_degrees": ("turn = [0.0, 0.0, 0.5]", "turn = [0.0, 0.0, 30.0]", "turn = [0.0, 0.0, 30.0]", "goal.turn", ["found [0, 0, 30]", "≤ 6.283", "write radians"]),
    "start_in_degrees": ("rotation.tail = [0.0, 0.0, 0.75]", "rotation.tail = [0.0, 0.0, -45.0]", "rotation.tail = [0.0, 0.0, -45.0]", "start.rotation.tail", ["found [0, 0, -45]", "≥ -6.283", "write radians"]),
    "joint_beyond_all_reason": ("child_offset = [-5.5, 0.0, 0.0]", "child_offset = [-5.5e9, 0.0, 0.0]", "child_offset = [-5.5e9", "joint[0].child_offset", ["a joint 5.5e+09 m from", "at most 8e+06 m", "mind the unit"]),
    "swing_at_a_mass_centre": ("child_offset = [-5.5, 0.0, 0.0]", "child_offset = [0.0, 0.0, 0.0]", "swing.neck", "limits.swing.neck", ["a joint at a mass centre", "not zero", "remove it"]),
    "twist_zero": ("twist.neck = 0.5", "twist.neck = 0", "twist.neck", "limits.twist.neck", ["found 0", "> 0 and ≤ 3.14159", "choose"]),
    "angle_reversed": ("angle.back = [-0.5, 1.5]", "angle.back = [1.5, -0.5]", "angle.back", "limits.angle.back", ["found [1.5, -0.5]", "min < max", "exchange"]),
    "angle_of_a_ball": ("angle.back", "angle.neck", "angle.neck", "limits.angle.neck", ["found a ball joint", "on hinges and universal joints", "limits.swing"]),
    "angle_of_one_axis": ("angle.tail = [[-0.4, 0.4], [-1.0, 0.5]]", "angle.tail = [-0.4, 0.4]", "angle.tail", "limits.angle.tail", ["found [-0.4, 0.4]", "two of [min, max]", "as in [["]),
    "angle_of_two_axes": ("angle.back = [-0.5, 1.5]", "angle.back = [[-0.5, 1.5], [-1.0, 1.0]]", "angle.back", "limits.angle.back", ["found [[-0.5, 1.5], [-1, 1]]", "[min, max] with", "as in [-0.5, 0.5]"]),
    "angle_of_second_axis_reversed": ("[-1.0, 0.5]]", "[0.5, -1.0]]", "angle.tail", "limits.angle.tail", ["found [[-0.4, 0.4], [0.5, -1]]", "min < max", "exchange"]),
    "clearance_negative": ("clearance = 0.1", "clearance = -0.1", "clearance", "limits.clearance", ["found -0.1", "≥ 0 (m)", "choose"]),
    "starts_zero": ("starts = 16", "starts = 0", "starts", "search.starts", ["found 0", "from 1 to 1000000", "choose"]),
    "whole_turns_negative": ("starts = 16", "starts = 16\nwhole_turns = -1", "whole_turns", "search.whole_turns", ["found -1", "from 0 to 1000000", "choose"]),
    "hops_negative": ("starts = 16", "starts = 16\nhops = -1", "hops", "search.hops", ["found -1", "from 0 to 1000000", "choose"]),
    "seed_negative": ("seed = 7", "seed = -7", "seed", "search.seed", ["found -7", "from 0 to", "choose"]),
    "method_shooting_with_steps": ("kind = \"spline\"\npoints = 21", "kind = \"steps\"", "method", "search.method", ["\"shooting\" with control.kind = \"steps\"", "\"simultaneous\"", "set control.kind = \"spline\""]),
    "tolerance_too_large": ("tolerance = 1e-7", "tolerance = 1.0", "tolerance", "search.tolerance", ["found 1", "≥ 1e-15 and ≤ 0.1", "choose"]),
    "time_limit_a_date": ("time_limit = 60.0", "time_limit = 2024-01-01", "time_limit", "search.time_limit", ["a date or time", "> 0 (s)", "without quotes"]),
    "key_twice": ("steps = 100", "steps = 100\nsteps = 200", "steps = 200", "time.steps", ["a second time", "once", "remove one"]),
    "key_of_all_and_of_one": ("torque.neck = 1500.0", "torque = 900.0\ntorque.neck = 1500.0", "torque.neck", "limits.torque.neck", ["one value for this key and values for keys below it", "either", "KEY.NAME"]),
    "key_twice_in_a_body": ("semi_axes = [5.0, 0.8, 1.5]", "semi_axes = [5.0, 0.8, 1.5]\nsemi_axes = [5.0, 0.8, 1.5]", "semi_axes = [5.0, 0.8, 1.5]#2", "body[1].semi_axes", ["a second time", "once in a table", "remove one"]),
    "body_in_single_brackets": ("[[body]]\nname = \"back\"", "[body]\nname = \"back\"", "[body]#3", "body", ["[body] as a table", "any number of [[body]]", "in double brackets"]),
    "table_twice": ("[integrator]", "[cost]\neffort = 1.0\n\n[integrator]", "[cost]#2", "cost", ["a second time", "once", "remove one"]),
    "syntax_text_without_quotes": ("scheme = \"midpoint\"", "scheme = midpoint", "scheme =", "integrator.scheme", ["TOML cannot read", "allowed: TOML", "mend this line"]),
    "nesting_brackets": ("turn = [0.0, 0.0, 0.5]", "turn = " + "[" * 65 + "]" * 65, "turn =", "file", ["deeper than 64", "at most 64", "flatten"]),
    "nesting_dots": ("turn = [0.0, 0.0, 0.5]", "turn" + ".x" * 100 + " = 1", "turn.x", "file", ["deeper than 64", "at most 64", "flatten"]),
    "limit_sphere_without_radius": ("radius = 0.75\n", "", "[[limits.sphere]]", "limits.sphere[0].radius", ["found nothing", "a number > 0 (m)", "add this key"]),
    "limit_half_space_without_direction": ("normal = [0.0, 0.5, 2.0]", "normal = [0, 0, 0]", "normal", "limits.half_space[0].normal", ["found [0, 0, 0]", "not all 0", "direction out"]),
    "limit_angular_velocity_negative": ("angular_velocity.back = 12.0", "angular_velocity.back = -1", "angular_velocity.back = -1", "limits.angular_velocity.back", ["found -1", "a number > 0 (rad/s)", "choose"]),
    "limit_rate_component_of_a_ball": ("angular_velocity_component = { back = 11.0, tail = 9.0 }", "angular_velocity_component.neck = 9.0", "angular_velocity_component.neck", "limits.angular_velocity_component.neck", ["found a ball joint", "on hinges and universal joints", "limits.angular_velocity.neck"]),
    "limit_rate_component_zero": ("{ back = 11.0, tail = 9.0 }", "{ back = 0.0 }", "angular_velocity_component = { back = 0.0 }", "limits.angular_velocity_component.back", ["found 0", "a number > 0 (rad/s)", "choose"]),
    "limit_torque_component_zero": ("torque_component = 900.0", "torque_component = 0", "torque_component", "limits.torque_component", ["found 0", "a number > 0 (N m)", "choose"]),
    "cost_work_negative": ("work = 2.5", "work = -1", "work = -1", "cost.work", ["found -1", "a number ≥ 0 ((N m)² s/J)", "choose"]),
    "cost_power_is_a_text": ("power = 0.25", "power = \"low\"", "power", "cost.power", ["found \"low\"", "a number", "without quotes"]),
    "cost_angular_velocity_negative": ("angular_velocity = 1.25", "angular_velocity = -1", "angular_velocity = -1", "cost.angular_velocity", ["found -1", "a number ≥ 0 ((N m)² s²/rad²)", "choose"]),
    "cost_key_unknown": ("smoothness = 0.125", "smothness = 1.0", "smothness", "cost.smothness", ["unknown key", "smoothness", "nearest known key is \"smoothness\""]),
    "cost_transport_infinite": ("transport = 3.5", "transport = inf", "transport", "cost.transport", ["found inf", "≥ 0", "finite"]),
    "displacement_of_a_given_axis": ("displacement = [0.0, 1.5, 0.0]", "displacement = [1.5, 0, 0]", "displacement", "cost.displacement", ["metres along x", "goal.move fixes", "\"free\" for x"]),
    "displacement_one_number": ("displacement = [0.0, 1.5, 0.0]", "displacement = 1.5", "displacement", "cost.displacement", ["found 1.5", "three numbers", "write"]),
    "smoothness_of_a_free_end": ([("periodic = true", "periodic = false"), ("free_shape = true", "free_shape = false")], None, "smoothness", "cost.smoothness", ["neither at rest nor periodic", "goal.rest = true", "free end"]),
    "transport_of_no_distance": ([("move = [2.0, \"free\", -1]", "move = [0.0, 0.0, 0.0]")], None, "transport", "cost.transport", ["0 m", "not zero", "cost.work"]),
    "cost_time_negative": ("time = 12.5", "time = -1", "time = -1", "cost.time", ["found -1", "a number ≥ 0 ((N m)²)", "choose"]),
    "waypoint_of_a_free_duration": ("[search]", "[[waypoint]]\ntime = 0.5\nmove = [1.0, \"free\", \"free\"]\n\n[search]", "[[waypoint]]", "waypoint[0]", ["free duration", "fixed times", "fix time.duration"]),
    "waypoint_between_nodes": ([(FREE, "duration = 1.0"), ("[search]", "[[waypoint]]\ntime = 0.505\nmove = [1.0, \"free\", \"free\"]\n\n[search]")], None, "time = 0.505", "waypoint[0].time", ["0.505 s", "a whole number of steps of 0.01 s", "as in 0.51"]),
    "waypoint_in_one_step": ([(FREE, "duration = 1.0"), ("steps = 100", "steps = 1"), ("[search]", "[[waypoint]]\ntime = 0.5\nmove = [1.0, \"free\", \"free\"]\n\n[search]")], None, "time = 0.5", "waypoint[0].time", ["0.5 s", "a whole number of steps of 1 s", "take more time.steps"]),
    "waypoint_asks_nothing": ([(FREE, "duration = 1.0"), ("[search]", "[[waypoint]]\ntime = 0.5\n\n[search]")], None, "[[waypoint]]", "waypoint[0]", ["nothing asked for", "at least one of", "remove the waypoint"]),
    "waypoints_contradict": ([(FREE, "duration = 1.0"), ("[search]", "[[waypoint]]\ntime = 0.5\nmove = [1.0, \"free\", \"free\"]\n\n[[waypoint]]\ntime = 0.5\nmove = [1.5, \"free\", \"free\"]\n\n[search]")], None, "move = [1.5", "waypoint[1].move", ["another move than that of waypoint[0]", "met together", "or its time"]),
    "waypoints_turn_otherwise": ([(FREE, "duration = 1.0"), ("[search]", "[[waypoint]]\ntime = 0.5\nturn = [0, 0, 0.5]\n\n[[waypoint]]\ntime = 0.5\nrotation.middle = [0, 0, 1]\n\n[search]")], None, "rotation.middle = [0, 0, 1]", "waypoint[1].rotation.middle", ["another rotation.middle than that of waypoint[0]", "met together", "or its time"]),
    "waypoint_of_an_unknown_body": ([(FREE, "duration = 1.0"), ("[search]", "[[waypoint]]\ntime = 0.5\nrotation.nose = [0, 0, 1]\n\n[search]")], None, "rotation.nose", "waypoint[0].rotation.nose", ["unknown key", "front", "known key"]),
    "section_is_a_value": ([(LIMITS, ""), ("schema = 1", "schema = 1\nlimits = 3")], None, "limits = 3", "limits", ["found 3", "a table", "write [limits]"]),
    "rest_of_what": ("rest = false", "rest = \"joint\"", "rest =", "goal.rest", ["found \"joint\"", "true, false or \"joints\"", "whole that drifts on"]),
    "rest_of_a_gait": ("rest = false", "rest = \"joints\"", "rest =", "goal.rest", ["\"joints\" with goal.periodic = true", "one of the two", "remove rest"]),
    "goal_asks_nothing": ([(GOAL, "[goal]\nrest = false\n"), ("free_shape = true\n", ""), ("displacement = [0.0, 1.5, 0.0]\n", "")], None, "[goal]", "goal", ["nothing asked for", "at least one of move", "add one"]),
    "syntax_comma_missing": ("[5.0, 0.8, 1.5]", "[5.0, 0.8 1.5]", "[5.0, 0.8 1.5]", "body[1].semi_axes", ["TOML cannot read", "allowed: TOML", "mend this line"]),
    "body_missing": ([(BODIES, "")], None, "# expect", "body", ["found nothing", "from 1 to 1000", "add this key"]),
    "body_single_brackets": ([(BODIES, "[body]\nname = \"middle\"\n\n")], None, "[body]", "body", ["found a table", "a list of tables", "[[body]] in double brackets"]),
    "too_many_bodies": ([(BODIES, "[[body]]\n" * 1001)], None, "[[body]]", "body", ["found 1001 bodies", "from 1 to 1000", "change the number"]),
}


def edited(old, new):
    text = VALID
    for before, after in old if new is None else [(old, new)]:
        assert before in text, before
        text = text.replace(before, after, 1)
    return text


def line_of(lines, mark):
    text, _, count = mark.partition("#") if not mark.startswith("#") else (mark, "", "")
    hits = [n for n, line in enumerate(lines, 1) if line.startswith(text) or (not text[0].isalpha() and text in line)]
    return hits[int(count or 1) - 1]


def main():
    folder = HERE / "malformed"
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.toml"):
        old.unlink()
    for name, (old, new, mark, key, fragments) in CASES.items():
        text = edited(old, new)
        line = line_of(["# expect"] + text.splitlines(), mark)
        (folder / f"{name}.toml").write_text(f"# expect: {line}: {key}: {' | '.join(fragments)}\n{text}", encoding="utf-8")
    print(f"{len(CASES)} malformed files")


if __name__ == "__main__":
    main()
