#include "task/model_table.hpp"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "document/text_table.hpp"
#include "file/problem_file.hpp"
#include "fluid/ellipsoid.hpp"
#include "fluid/gap.hpp"
#include "model/input_error.hpp"
#include "task/model_remarks.hpp"

namespace lamprey::task {

namespace {

using Eigen::Vector3d;

maneuver::Problem two_bodies() {
  maneuver::Problem problem;
  problem.name = "Two bodies";
  problem.swimmer.density = 1000.0;
  problem.swimmer.bodies.resize(2);
  problem.swimmer.bodies[0].name = "head";
  problem.swimmer.bodies[0].semi_axes = {1.0, 0.2, 0.3};
  problem.swimmer.bodies[1].name = "tail";
  problem.swimmer.bodies[1].semi_axes = {0.5, 0.2, 0.2};
  model::JointDescription joint;
  joint.name = "hip";
  joint.parent = "head";
  joint.child = "tail";
  joint.parent_offset = {-1.1, 0.0, 0.0};
  joint.child_offset = {0.65, 0.0, 0.0};
  problem.swimmer.joints = {joint};
  problem.start.rotation.assign(2, Vector3d::Zero());
  problem.start.angular_velocity.assign(2, Vector3d::Zero());
  problem.goal.emplace();
  problem.goal->move[0] = 2.5;
  return problem;
}

std::string table_of(const maneuver::Problem& problem) {
  const model::System system(problem.swimmer);
  return model_table(problem, system, model_remarks(problem, system));
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST(ModelTable, names_every_body_and_joint_and_tells_the_task_in_words) {
  const std::string text = table_of(two_bodies());
  for (const char* part : {"Two bodies", "head", "tail", "hip", "ball", "2.5 m along e₁, free along e₂",
                           "e₁, e₂, e₃ are the world's x, y, z", "ends at rest", "1 s in 1000 steps of 0.001 s",
                           "trapezoid", "one value at each node"}) {
    EXPECT_TRUE(contains(text, part)) << part << " is missing from\n" << text;
  }
}

TEST(ModelTable, tells_gaits_what_is_free_and_what_is_asked) {
  maneuver::Problem problem = two_bodies();
  EXPECT_TRUE(contains(table_of(problem), "m, at rest"));
  problem.goal->periodic = true;
  problem.goal->rest = false;
  EXPECT_TRUE(contains(table_of(problem), "a gait: shape and velocity at the end equal those at the start"));
  EXPECT_TRUE(contains(table_of(problem), "m, velocity is free")) << table_of(problem);
  EXPECT_FALSE(contains(table_of(problem), "velocities at the end are free"));
  problem.goal->turn = Eigen::Vector3d::Zero();
  EXPECT_TRUE(contains(table_of(problem), "the root ends with its start rotation")) << table_of(problem);
  problem.start.free_shape = true;
  EXPECT_TRUE(contains(table_of(problem), "shape and velocity are free (first guess of the shape as in the file)"));
}

TEST(ModelTable, tells_bodies_that_overlap_from_bodies_that_do_not) {
  maneuver::Problem problem = two_bodies();
  EXPECT_TRUE(contains(table_of(problem), "0.25  apart")) << table_of(problem);
  EXPECT_FALSE(contains(table_of(problem), "OVERLAP"));
  problem.swimmer.joints[0].parent_offset.x() = -0.7;
  const auto& bodies = problem.swimmer.bodies;
  const Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
  const double gap = fluid::gap({bodies[0].semi_axes, bodies[1].semi_axes, upright, upright, {-1.35, 0.0, 0.0}}).value;
  EXPECT_LT(gap, 0.0);
  EXPECT_GT(gap, -0.15) << "the way out sideways is shorter than along";
  EXPECT_TRUE(contains(table_of(problem), document::short_number(gap) + "  OVERLAP")) << table_of(problem);
}

TEST(ModelTable, shows_the_least_distance_of_neighbours_and_leaves_out_far_bodies_that_no_joint_holds) {
  maneuver::Problem problem = two_bodies();
  problem.swimmer.joints[0].parent_offset = {0.6, 0.5, 0.0};
  problem.swimmer.joints[0].child_offset = {-0.3, 0.0, 0.0};
  const auto& bodies = problem.swimmer.bodies;
  const Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
  const double gap = fluid::gap({bodies[0].semi_axes, bodies[1].semi_axes, upright, upright, {0.9, 0.5, 0.0}}).value;
  EXPECT_TRUE(contains(table_of(problem), document::short_number(gap) + "  apart")) << table_of(problem);
  problem.swimmer.bodies.push_back(problem.swimmer.bodies[1]);
  problem.swimmer.bodies[2].name = "fin";
  problem.swimmer.joints.push_back(problem.swimmer.joints[0]);
  problem.swimmer.joints[1].name = problem.swimmer.joints[1].child = "fin";
  problem.swimmer.joints[1].parent_offset = {0.0, -5.0, 0.0};
  problem.start.rotation.assign(3, Vector3d::Zero());
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  EXPECT_TRUE(contains(table_of(problem), "\n  head  fin ")) << table_of(problem);
  EXPECT_FALSE(contains(table_of(problem), "\n  tail  fin "));
}

TEST(ModelTable, says_which_matrices_the_file_gave_and_shows_their_off_diagonal_entries) {
  maneuver::Problem problem = two_bodies();
  EXPECT_FALSE(contains(table_of(problem), "as given"));
  EXPECT_FALSE(contains(table_of(problem), "entries 12, 13, 23"));
  Eigen::Matrix3d J = Vector3d(100.0, 200.0, 300.0).asDiagonal();
  J(0, 1) = J(1, 0) = 7.25;
  problem.swimmer.bodies[0].inertia_matrix = J;
  EXPECT_TRUE(contains(table_of(problem), "J, as given"));
  EXPECT_TRUE(contains(table_of(problem), "7.25"));
}

maneuver::Problem hinged_bodies() {
  maneuver::Problem problem = two_bodies();
  model::JointDescription& joint = problem.swimmer.joints[0];
  joint.kind = model::JointKind::hinge;
  joint.axis = Vector3d(0.0, 0.0, 2.0);
  joint.reference_rotation = {0.0, 0.0, 0.125};
  joint.stiffness = 3.5;
  joint.damping = 0.75;
  return problem;
}

TEST(ModelTable, says_what_joints_leave_free_and_what_springs_and_dampers_they_have) {
  EXPECT_FALSE(contains(table_of(two_bodies()), "Freedoms of the joints"));
  const std::string hinge = table_of(hinged_bodies());
  for (const char* part : {"hip  hinge", "hip  1: c (0, 0, 1)  (0, 0, 0.125)", "3.5     0.75"})
    EXPECT_TRUE(contains(hinge, part)) << part << " is missing from\n" << hinge;
  maneuver::Problem problem = hinged_bodies();
  problem.swimmer.joints[0].kind = model::JointKind::universal;
  problem.swimmer.joints[0].reference_rotation.setZero();
  problem.swimmer.joints[0].axes = {Vector3d(0.0, 0.0, 1.0), Vector3d(0.0, 3.0, 0.0)};
  problem.swimmer.joints[0].control_axes = {Vector3d(0.0, 1.0, 0.0)};
  problem.swimmer.joints[0].damping = 0.0;
  const std::string universal = table_of(problem);
  for (const char* part : {"2: p (0, 0, 1), c (0, 1, 0)", "3.5     none"})
    EXPECT_TRUE(contains(universal, part)) << part << " is missing from\n" << universal;
}

TEST(ModelTable, shows_a_coupling_matrix_row_by_row) {
  maneuver::Problem problem = two_bodies();
  EXPECT_FALSE(contains(table_of(problem), "C, as given"));
  problem.swimmer.bodies[1].coupling_matrix = Eigen::Matrix3d::Zero();
  (*problem.swimmer.bodies[1].coupling_matrix)(1, 2) = 0.375;
  EXPECT_TRUE(contains(table_of(problem), "C, as given"));
  EXPECT_TRUE(contains(table_of(problem), "0.375  kg m"));
}

TEST(ModelTable, shows_the_inertia_of_equal_bodies_in_a_row_once) {
  maneuver::Problem problem = two_bodies();
  EXPECT_FALSE(contains(table_of(problem), "head … tail"));
  problem.swimmer.bodies[1].semi_axes = problem.swimmer.bodies[0].semi_axes;
  EXPECT_TRUE(contains(table_of(problem), "head … tail")) << table_of(problem);
  problem.swimmer.bodies[1].mass = 1000.0;
  EXPECT_FALSE(contains(table_of(problem), "head … tail"));
}

std::vector<std::string> remarks_of(const maneuver::Problem& problem) {
  return model_remarks(problem, model::System(problem.swimmer));
}

TEST(ModelRemarks, are_none_for_the_examples) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(LAMPREY_SOURCE_DIR "/examples")) {
    if (entry.path().extension() != ".toml") continue;
    const file::ProblemFile file = file::read_problem_file(entry.path());
    const std::vector<std::string> remarks = model_remarks(file, model::System(file.problem.swimmer));
    if (entry.path().parent_path().filename() == "as_printed") {  // the paper's misprint is one
      ASSERT_EQ(remarks.size(), 1U) << entry.path();
      EXPECT_TRUE(contains(remarks.front(), "begin within each other")) << remarks.front();
      continue;
    }
    EXPECT_EQ(remarks, std::vector<std::string>()) << entry.path();
  }
}

// A child's offset with the wrong sign puts it into its parent; rotors are meant to be inside.
TEST(ModelRemarks, tell_of_bodies_that_begin_within_each_other) {
  const auto told = [](const maneuver::Problem& problem) {
    const std::vector<std::string> remarks = remarks_of(problem);
    return std::any_of(remarks.begin(), remarks.end(), [](const std::string& remark) {
      return contains(remark, "head and tail begin within each other, the mass centre of each inside of the other");
    });
  };
  maneuver::Problem problem = two_bodies();
  Vector3d &parent = problem.swimmer.joints[0].parent_offset, &child = problem.swimmer.joints[0].child_offset;
  child = -child;
  EXPECT_TRUE(told(problem)) << "0.45 m beside each other, of 0.5 m and 1 m";
  problem.start.rotation[1] = Vector3d(0.0, 0.0, M_PI);
  EXPECT_FALSE(told(problem)) << "it begins turned round";
  problem.start.rotation[0] = Vector3d(0.0, 0.0, M_PI);
  EXPECT_TRUE(told(problem)) << "both do";
  problem.start.rotation.assign(2, Vector3d::Zero());
  parent = {-1.14, 0.0, 0.0};
  EXPECT_TRUE(told(problem)) << "0.49 m";
  parent = {-1.17, 0.0, 0.0};
  EXPECT_FALSE(told(problem)) << "0.52 m: the head's centre is outside of the tail";
  parent = {0.1, 0.0, 0.0};
  child = Vector3d::Zero();
  EXPECT_FALSE(told(problem)) << "a rotor within the head";
}

// Lengths of bodies in mm beside offsets in m, of all bodies or of one.
TEST(ModelRemarks, tell_of_lengths_in_two_units) {
  const auto told = [](const maneuver::Problem& problem, const std::string& key) {
    const std::vector<std::string> remarks = remarks_of(problem);
    return std::any_of(remarks.begin(), remarks.end(), [&](const std::string& remark) {
      return remark.starts_with(key + ": the joint sits") && contains(remark, "are semi_axes and offsets both in m?");
    });
  };
  for (const bool first : {false, true})
    for (const bool second : {false, true}) {
      maneuver::Problem problem = two_bodies();
      if (first) problem.swimmer.bodies[0].semi_axes *= 1e3;
      if (second) problem.swimmer.bodies[1].semi_axes *= 1e3;
      EXPECT_EQ(told(problem, "hip.parent_offset"), first);
      EXPECT_EQ(told(problem, "hip.child_offset"), second);
    }
  maneuver::Problem rotor = two_bodies();
  rotor.swimmer.joints[0].child_offset = Vector3d::Zero();
  EXPECT_FALSE(told(rotor, "hip.child_offset"));
}

// A fin on a ball joint does not turn with the hull, as one on a hinge does.
TEST(ModelRemarks, tell_of_bodies_on_ball_joints_that_a_turned_hull_leaves_behind) {
  const auto told = [](const std::string& kind, const std::string& start, const std::string& joint_keys = "") {
    const std::string bodies =
        "schema = 1\nname = \"n\"\n[fluid]\ndensity = 1000.0\n"
        "[[body]]\nname = \"hull\"\nsemi_axes = [0.3, 0.1, 0.1]\n"
        "[[body]]\nname = \"fin\"\nsemi_axes = [0.2, 0.05, 0.1]\n"
        "[[joint]]\nname = \"hip\"\nparent = \"hull\"\nchild = \"fin\"\nparent_offset = [-0.32, 0.0, 0.0]\n"
        "child_offset = [0.22, 0.0, 0.0]\n" +
        kind + joint_keys + "[time]\nduration = 1.0\nsteps = 10\n[start]\n";
    const file::ProblemFile file = file::parse_problem(bodies + start, "p.toml");
    const std::vector<std::string> remarks = model_remarks(file, model::System(file.problem.swimmer));
    return remarks.empty() ? "" : remarks.back();
  };
  const std::string hull = "rotation.hull = [0.0, 0.0, 0.29]\n", hinge = "kind = \"hinge\"\naxis = [0, 0, 1]\n";
  EXPECT_EQ(told("", hull),
            "hull begins turned, fin (on a ball joint) does not turn with it, so that the joint begins bent by 0.29 "
            "rad; give start.rotation.fin, or start.angle.hip = [0, 0, 0] to begin straight");
  EXPECT_EQ(told(hinge, hull), "");
  EXPECT_EQ(told("", ""), "");
  EXPECT_EQ(told("", hull + "rotation.fin = [0.0, 0.0, 0.0]\n"), "") << "as it is stated";
  EXPECT_EQ(told("", hull + "angle.hip = [0.0, 0.0, 0.0]\n"), "");
  EXPECT_EQ(told("", hull, "reference_rotation = [0.0, 0.0, -0.29]\n"), "") << "turned so that the joint is straight";
}

TEST(ModelRemarks, tell_of_slips) {
  using Change = std::function<void(maneuver::Problem&)>;
  const auto body = [](const std::function<void(model::BodyDescription&)>& change) {
    return [change](maneuver::Problem& problem) { change(problem.swimmer.bodies[1]); };
  };
  EXPECT_TRUE(remarks_of(two_bodies()).empty());
  for (const auto& [change, words] : std::vector<std::pair<Change, std::string>>{
           {body([](auto& b) { b.mass = 1e-30; }), "tail has 1e-30 kg and displaces 83.7758 kg"},
           {body([](auto& b) { b.mass = 83.8e3; }), "tail has 83800 kg"},
           {body([](auto& b) { b.mass = 100.0; }), "N of weight, which the model leaves out"},
           {body([](auto& b) { b.mass = 70.0; }), "N of buoyancy, which the model leaves out"},
           {[](maneuver::Problem& p) { p.swimmer.density = 1.025; }, "a fluid of 1.025 kg/m³ is a gas"},
           {body([](auto& b) { b.mass_matrix = 10.0 * Eigen::Matrix3d::Identity(); }), "tail.mass_matrix is less"},
           {body([](auto& b) { b.inertia_matrix = 0.1 * Eigen::Matrix3d::Identity(); }), "tail.inertia_matrix is less"},
           {body([](auto& b) { b.semi_axes *= 1e-3; }), "inertias of head and tail differ by a factor of"},
           {[](maneuver::Problem& p) { p.swimmer.joints[0].child_offset *= 10.0; },
            "hip.child_offset: the joint sits 6.5 m"},
           {[](maneuver::Problem& p) { p.swimmer.joints[0].parent_offset *= 2.0; }, "hip.parent_offset: "},
           {[](maneuver::Problem& p) { p.goal->move[1] = 16.0; }, "goal.move is 5.4 lengths"},
           {[](maneuver::Problem& p) { p.start.linear_velocity = Eigen::Vector3d(4000.0, 0, 0); },
            "lengths on in each step; is it meant in m/s?"},
           {[](maneuver::Problem& p) { p.goal->turn = Eigen::Vector3d(0, 0, 5.0); },
            "goal.turn turns by 5 rad, which ends where 1.28319 rad the other way do"},
           {[](maneuver::Problem& p) { p.goal->rotation["tail"] = Eigen::Vector3d(0, 3.2, 0); },
            "goal.rotation.tail turns by 3.2 rad"},
           {[](maneuver::Problem& p) { p.goal->angle["hip"] = {4.0}; },
            "goal.angle.hip of 4 rad ends where -2.28319 rad does"}}) {
    maneuver::Problem problem = two_bodies();
    change(problem);
    const std::vector<std::string> remarks = remarks_of(problem);
    EXPECT_TRUE(std::any_of(remarks.begin(), remarks.end(), [&](const auto& r) { return contains(r, words); }))
        << words << ": " << (remarks.empty() ? "nothing" : remarks[0]);
    EXPECT_TRUE(contains(table_of(problem), "Worth a second look"));
  }
}

// Hinges whose axes would be parallel with all digits of π.
TEST(ModelRemarks, tell_of_axes_that_were_meant_to_be_parallel) {
  maneuver::Problem problem = two_bodies();
  model::BodyDescription tip = problem.swimmer.bodies[1];
  tip.name = "tip";
  problem.swimmer.bodies.push_back(tip);
  model::JointDescription second = problem.swimmer.joints[0];
  second.name = "second";
  second.parent = "tail";
  second.child = "tip";
  second.parent_offset = {-0.65, 0.0, 0.0};
  problem.swimmer.joints.push_back(second);
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  for (model::JointDescription& joint : problem.swimmer.joints) {
    joint.kind = model::JointKind::hinge;
    joint.axis = Vector3d::UnitZ();
  }
  const auto told = [&](double half_turn) {
    problem.swimmer.joints[1].reference_rotation = {half_turn, 0.0, 0.0};
    problem.start.rotation = {Vector3d::Zero(), Vector3d::Zero(), Vector3d(half_turn, 0.0, 0.0)};
    const std::vector<std::string> remarks = remarks_of(problem);
    return std::any_of(remarks.begin(), remarks.end(), [](const std::string& remark) {
      return contains(remark, "the axes of hip and second are parallel but for 7e-06 rad");
    });
  };
  EXPECT_TRUE(told(3.1416));
  EXPECT_FALSE(told(M_PI));
  EXPECT_FALSE(told(0.3));
}

// A third body at the end of the second one, so many times smaller.
maneuver::Problem with_a_fin(double times) {
  maneuver::Problem problem = two_bodies();
  model::BodyDescription fin = problem.swimmer.bodies[1];
  fin.name = "fin";
  fin.semi_axes /= times;
  model::JointDescription root = problem.swimmer.joints[0];
  root.name = "root";
  root.parent = problem.swimmer.bodies[1].name;
  root.child = fin.name;
  root.parent_offset = -root.child_offset;
  root.child_offset /= times;
  problem.swimmer.bodies.push_back(fin);
  problem.swimmer.joints.push_back(root);
  problem.start.rotation.push_back(Eigen::Vector3d::Zero());
  return problem;
}

// Inertia about a joint grows with the fifth power of length: 1,000 times of it are 4 times of that.
TEST(ModelRemarks, tell_of_bodies_whose_moments_cost_next_to_nothing) {
  EXPECT_TRUE(remarks_of(with_a_fin(2.0)).empty()) << remarks_of(with_a_fin(2.0))[0];
  maneuver::Problem problem = with_a_fin(8.0);
  const std::vector<std::string> remarks = remarks_of(problem);
  ASSERT_EQ(remarks.size(), 1U);
  EXPECT_TRUE(contains(remarks[0], "a moment turns what joint root moves some ")) << remarks[0];
  EXPECT_TRUE(contains(remarks[0], " times as fast as one at joint hip: ")) << remarks[0];
  EXPECT_TRUE(contains(remarks[0], "limits.angular_velocity.root")) << remarks[0];
  const auto remains = [&](const std::function<void(maneuver::Problem&)>& mend) {
    maneuver::Problem mended = problem;
    mend(mended);
    return !remarks_of(mended).empty();
  };
  EXPECT_FALSE(remains([](auto& p) { p.limits.angular_velocity = 6.0; }));
  EXPECT_FALSE(remains([](auto& p) { p.limits.joint_angular_velocity["root"] = 6.0; }));
  EXPECT_TRUE(remains([](auto& p) { p.limits.joint_angular_velocity["hip"] = 6.0; }));
  EXPECT_FALSE(remains([](auto& p) { p.swimmer.joints[1].actuated = false; }));
  EXPECT_FALSE(remains([](auto& p) { p.goal.reset(); }));
}

class WidthOfTable : public ::testing::TestWithParam<maneuver::Problem> {};
INSTANTIATE_TEST_SUITE_P(ModelTable, WidthOfTable, ::testing::Values(two_bodies(), hinged_bodies()),
                         [](const auto& instance) { return instance.index == 0 ? "ball" : "hinge"; });

TEST_P(WidthOfTable, fits_into_a_hundred_columns) {
  const std::string text = table_of(GetParam());
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = text.find('\n', begin);
    ASSERT_NE(end, std::string::npos);
    EXPECT_LE(end - begin, 100U) << text.substr(begin, end - begin);
    begin = end + 1;
  }
}

TEST(ModelTable, lets_no_control_character_of_a_name_through) {
  maneuver::Problem problem = two_bodies();
  problem.name = "red\x1b[31m\r\n";
  problem.swimmer.bodies[1].name = problem.swimmer.joints[0].child = "ta\x7fil\x07";
  const std::string text = table_of(problem);
  EXPECT_TRUE(contains(text, "red?[31m??\n"));
  for (const char c : text) EXPECT_TRUE(c == '\n' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7F));
}

TEST(InertiaJson, holds_the_seven_fields_with_all_digits) {
  const auto document = nlohmann::json::parse(inertia_json(Eigen::Vector3d(8.0, 1.5, 2.0), 3.0));
  const auto inertia = fluid::ellipsoid_inertia({8.0, 1.5, 2.0}, 3.0);
  EXPECT_EQ(document.size(), 7U);
  EXPECT_EQ(document.at("volume").get<double>(), inertia.volume);
  EXPECT_EQ(document.at("mass").get<double>(), inertia.mass);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    EXPECT_EQ(document.at("body_inertia").at(i).get<double>(), inertia.body_inertia[k]);
    EXPECT_EQ(document.at("added_mass").at(i).get<double>(), inertia.added_mass[k]);
    EXPECT_EQ(document.at("added_inertia").at(i).get<double>(), inertia.added_inertia[k]);
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_EQ(document.at("mass_matrix").at(i).at(j).get<double>(),
                i == j ? inertia.mass + inertia.added_mass[k] : 0.0);
      EXPECT_EQ(document.at("inertia_matrix").at(i).at(j).get<double>(),
                i == j ? inertia.body_inertia[k] + inertia.added_inertia[k] : 0.0);
    }
  }
}

TEST(InertiaTable, refuses_what_is_no_body) {
  EXPECT_THROW(inertia_table(Eigen::Vector3d(1.0, 0.0, 1.0), 1.0), model::InputError);
  EXPECT_THROW(inertia_table(Eigen::Vector3d(1.0, 1.0, 1.0), -1.0), model::InputError);
  EXPECT_THROW(inertia_json(Eigen::Vector3d(1e120, 1e120, 1e120), 1.0), model::InputError);
  EXPECT_NE(inertia_table(Eigen::Vector3d(1.0, 1.0, 1.0), 1.0).find("4.18879"), std::string::npos);
  EXPECT_NE(inertia_table(Eigen::Vector2d(1.0, 1.0), 1.0).find("ellipse, one metre deep, in fluid"), std::string::npos);
  EXPECT_THROW(inertia_json(Eigen::Vector2d(1.0, -1.0), 1.0), model::InputError);
}

}  // namespace lamprey::task
