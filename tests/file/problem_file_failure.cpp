#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "document/io_error.hpp"
#include "file/problem_file.hpp"
#include "file/samples.hpp"
#include "fluid/gap.hpp"
#include "task/tasks.hpp"

namespace lamprey {
namespace {

using file::parse_problem;
using model::InputError;

struct Expectation {
  int line = 0;
  std::string key;
  std::vector<std::string> fragments;
};

std::vector<std::string> split(const std::string& text, const std::string& separator) {
  std::vector<std::string> parts;
  std::size_t start = 0;
  while (true) {
    const std::size_t end = std::min(text.find(separator, start), text.size());
    parts.push_back(text.substr(start, end - start));
    if (end == text.size()) return parts;
    start = end + separator.size();
  }
}

Expectation expectation_of(const std::string& bytes) {
  const std::string mark = "# expect: ";
  EXPECT_EQ(bytes.substr(0, mark.size()), mark);
  const std::string head = bytes.substr(mark.size(), bytes.find('\n') - mark.size());
  const std::size_t line_end = head.find(": ");
  const std::size_t key_end = head.find(": ", line_end + 2);
  return {std::stoi(head.substr(0, line_end)), head.substr(line_end + 2, key_end - line_end - 2),
          split(head.substr(key_end + 2), " | ")};
}

std::vector<std::filesystem::path> malformed_files() {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(tests::folder_of_tests() + "malformed"))
    paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  return paths;
}

void expect_refused(const std::string& path) {
  const Expectation expected = expectation_of(tests::bytes_of(path));
  ASSERT_EQ(expected.fragments.size(), 3U) << "found, allowed, cure";
  try {
    file::read_problem(path);
    FAIL() << path << " was accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.line, expected.line) << error.what();
    EXPECT_EQ(error.key, expected.key) << error.what();
    EXPECT_GE(error.column, 1);
    for (const std::string& fragment : expected.fragments)
      EXPECT_NE(error.message.find(fragment), std::string::npos) << fragment << "\n" << error.what();
    const std::string start =
        path + ":" + std::to_string(error.line) + ":" + std::to_string(error.column) + ": " + error.key + ": ";
    EXPECT_EQ(std::string(error.what()), start + error.message);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

// Reads or refuses; anything else (a crash, another exception) fails. True when the text was accepted.
bool survives(const std::string& text) {
  try {
    parse_problem(text, "mutant.toml");
    return true;
  } catch (const InputError& error) {
    EXPECT_GE(error.line, 1);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return false;
  }
}

TEST(MalformedProblem, every_rule_is_told_with_its_line_and_key_what_was_found_what_is_allowed_and_the_cure) {
  const auto paths = malformed_files();
  EXPECT_GE(paths.size(), 40U);
  for (const auto& path : paths) {
    SCOPED_TRACE(path.filename().string());
    expect_refused(path.string());
  }
}

TEST(MalformedProblem, the_file_they_were_made_from_is_accepted) {
  EXPECT_NO_THROW(file::read_problem(tests::folder_of_tests() + "valid.toml"));
}

TEST(MalformedProblem, a_missing_file_and_a_folder_are_failures_of_reading_not_of_content) {
  EXPECT_THROW(file::read_problem(tests::folder_of_tests() + "no_such_file.toml"), document::IoError);
  EXPECT_THROW(file::read_problem(tests::folder_of_tests()), document::IoError);
}

TEST(MalformedProblem, more_than_16_mebibytes_are_refused_and_exactly_16_are_read) {
  std::string text = tests::bytes_of(tests::folder_of_tests() + "valid.toml");
  text += "#" + std::string((std::size_t{16} << 20) - text.size() - 1, 'x');
  EXPECT_TRUE(survives(text));
  EXPECT_FALSE(survives(text + "x"));
}

TEST(MalformedProblem, nesting_of_any_depth_is_refused_without_harm) {
  for (const std::string opening : {"[", "{a=", "[{a=", "a.", "\"a\"."}) {
    std::string text = "x = ";
    if (opening.back() == '.') text = "";
    while (text.size() < 8'000'000) text += opening;
    EXPECT_FALSE(survives(text)) << opening;
    EXPECT_FALSE(survives("[" + text)) << opening;
  }
}

TEST(MalformedProblem, brackets_and_dots_inside_texts_and_comments_do_not_nest) {
  const std::string deep = std::string(100, '[') + std::string(100, '.');
  const std::string valid = tests::bytes_of(tests::folder_of_tests() + "valid.toml");
  for (const std::string& text : {"\"" + deep + "\"", "'" + deep + "'", "\"\"\"\n" + deep + "\n\"\"\"\"\"",
                                  "'''" + deep + "'''", "\"\\\"" + deep + "\" #" + deep}) {
    std::string edited = valid;
    edited.replace(edited.find("\"made up\""), 9, text);
    EXPECT_TRUE(survives(edited)) << text;
  }
}

TEST(MalformedProblem, input_that_stops_the_parser_short_is_refused_at_its_line) {
  const std::string valid = tests::bytes_of(tests::folder_of_tests() + "valid.toml");
  for (const std::string line : {"[=", "[=]", "[[=]]", "[ ", "[", "[[", "[]", "= 1", "a.", "a. = 1", "a = ", "a = +",
                                 "a = [1,,2]", "a = {b = }"}) {
    try {
      parse_problem("schema = 1\n" + line + "\n" + valid, "x");
      FAIL() << line;
    } catch (const InputError& error) {
      EXPECT_EQ(error.line, 2) << error.what();
    }
  }
}

TEST(MalformedProblem, truncation_at_every_byte_reads_or_is_refused) {
  const std::string valid = tests::bytes_of(tests::folder_of_tests() + "valid.toml");
  int refused = 0;
  for (std::size_t length = 0; length < valid.size(); ++length) refused += survives(valid.substr(0, length)) ? 0 : 1;
  EXPECT_GT(refused, static_cast<int>(valid.size() / 2));
}

TEST(MalformedProblem, one_changed_byte_reads_or_is_refused) {
  const std::string valid = tests::bytes_of(tests::folder_of_tests() + "valid.toml");
  std::mt19937 random(20240);
  int accepted = 0;
  int refused = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    std::string mutant = valid;
    const char* likely = "[]{}.,=\"'#\n-0123456789einf\\";
    const char byte = trial % 2 == 0 ? static_cast<char>(random() % 256) : likely[random() % 27];
    mutant[random() % mutant.size()] = byte;
    (survives(mutant) ? accepted : refused) += 1;
  }
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 1000);
}

// Two bodies in a row, the second bent by half a radian about e_3; what follows is of the limits.
std::string bent_pair(const std::string& start, const std::string& limits) {
  return "schema = 1\n[fluid]\ndensity = 1000.0\n"
         "[[body]]\nname = \"a\"\nsemi_axes = [0.5, 0.1, 0.1]\n[[body]]\nname = \"b\"\nsemi_axes = [0.5, 0.1, 0.1]\n"
         "[[joint]]\nkind = \"hinge\"\nname = \"neck\"\nparent = \"a\"\nchild = \"b\"\naxis = [0, 0, 1]\n"
         "parent_offset = [0.52, 0, 0]\nchild_offset = [-0.52, 0, 0]\n"
         "[start]\nrotation.b = [0.0, 0.0, 0.5]\n" +
         start +
         "[goal]\nmove = [0.1, \"free\", \"free\"]\nperiodic = true\n[time]\nduration = 1.0\nsteps = 10\n[limits]\n" +
         limits;
}

TEST(StartBeyondALimit, is_told_at_the_limit_with_by_how_much_unless_shapes_are_free) {
  for (const auto& [limits, key, fragment] :
       {std::tuple("angle.neck = [-0.3, 0.3]\n", "limits.angle.neck", "by 0.2 rad"),
        std::tuple("swing.neck = 0.4\n", "limits.swing.neck", "by 0.1 rad"),
        std::tuple("clearance = 0.039\n", "limits.clearance", "m;"),
        std::tuple("sphere = [{ centre = [0.0, 0.0, 0.0], radius = 0.1 }]\n", "limits.sphere[0]", "m;"),
        std::tuple("half_space = [{ point = [0, 0, 0], normal = [0, 0, 1] }]\n", "limits.half_space[0]", "by 0.1 m")}) {
    try {
      file::require_ends_within_limits(parse_problem(bent_pair("", limits), "pair.toml"));
      ADD_FAILURE() << limits << " was taken as kept";
    } catch (const InputError& error) {
      EXPECT_EQ(error.key, key) << error.what();
      EXPECT_GT(error.line, 20) << error.what();
      EXPECT_NE(error.message.find(fragment), std::string::npos) << error.what();
    }
    std::string of_free_shape;  // which moves no root
    try {
      file::require_ends_within_limits(parse_problem(bent_pair("free_shape = true\n", limits), "pair.toml"));
    } catch (const InputError& error) {
      of_free_shape = error.key;
      EXPECT_NE(error.message.find("the root's smallest semi-axis"), std::string::npos) << error.what();
    }
    const bool of_root = std::string_view(key).ends_with("[0]");
    EXPECT_EQ(of_free_shape, of_root ? "start.position" : "");
  }
  EXPECT_NO_THROW(
      file::require_ends_within_limits(parse_problem(bent_pair("", "angle.neck = [-0.5, 0.5]\n"), "pair.toml")));
}

// A swing counts by its angle: the cosine of a narrow cone hardly knows what is beyond it.
TEST(StartBeyondALimit, is_told_of_narrow_swings_too) {
  const auto start_at = [](const std::string& angle) {
    std::string text = bent_pair("", "swing.neck = 1e-4\n");
    const std::string bent = "rotation.b = [0.0, 0.0, 0.5]";
    file::require_ends_within_limits(parse_problem(
        text.replace(text.find(bent), bent.size(), "rotation.b = [0.0, 0.0, " + angle + "]"), "pair.toml"));
  };
  EXPECT_NO_THROW(start_at("1e-4"));
  EXPECT_THROW(start_at("1.001e-4"), InputError);
  EXPECT_THROW(start_at("-1.09e-4"), InputError);
}

TEST(GaitOfAnyDisplacement, is_refused_where_nothing_pays_for_a_way) {
  const auto problem = [](const std::string& start, const std::string& cost) {
    std::string text = bent_pair(start, "angle.neck = [-1.0, 1.0]\n") + cost;
    const std::string asked = "move = [0.1, \"free\", \"free\"]\n";
    return parse_problem(text.replace(text.find(asked), asked.size(), ""), "pair.toml");
  };
  try {
    problem("free_shape = true\n", "");
    ADD_FAILURE() << "rest was taken for a gait";
  } catch (const InputError& error) {
    EXPECT_EQ(error.key, "goal") << error.what();
    EXPECT_NE(error.message.find("the cheapest is to stay at rest"), std::string::npos) << error.what();
  }
  EXPECT_NO_THROW(problem("free_shape = true\n", "[cost]\neffort = 1.0\ntransport = 1.0\n"));
  EXPECT_NO_THROW(problem("", "")) << "held in a shape";
}

TEST(ClearanceOfJoinedBodies, is_at_most_what_the_joint_leaves) {
  const auto expect = [](double clearance, bool allowed) {
    const auto file =
        parse_problem(bent_pair("free_shape = true\n", "clearance = " + std::to_string(clearance) + "\n"), "pair.toml");
    if (allowed) {
      EXPECT_NO_THROW(file::require_supported(file, file::Purpose::solve)) << clearance;
      return;
    }
    try {
      file::require_supported(file, file::Purpose::solve);
      ADD_FAILURE() << clearance << " was taken as possible";
    } catch (const InputError& error) {
      EXPECT_EQ(error.key, "limits.clearance") << error.what();
      EXPECT_NE(error.message.find("at most 0.04 m, which joint neck leaves between a and b"), std::string::npos)
          << error.what();
    }
  };
  expect(0.0399, true);
  expect(0.0401, false);
  // a given start breaks it, too, and another start would
  try {
    file::require_ends_within_limits(parse_problem(bent_pair("", "clearance = 0.5\n"), "pair.toml"));
    ADD_FAILURE() << "was taken as possible";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("at most 0.04 m"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("pair.toml:"), std::string::npos) << error.what();
  }
  // which straight bodies have and bent ones do not
  const fluid::EllipsoidPair straight{Eigen::Vector3d(0.5, 0.1, 0.1), Eigen::Vector3d(0.5, 0.1, 0.1),
                                      Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity(),
                                      Eigen::Vector3d(1.04, 0.0, 0.0)};
  EXPECT_NEAR(fluid::gap(straight).value, 0.04, 1e-12);
}

TEST(GoalBeyondALimit, is_told_at_the_limit_where_the_goal_fixes_what_it_limits) {
  const auto problem = [](const std::string& goal, const std::string& limits) {
    std::string text = bent_pair("", limits);
    const std::string asked = "move = [0.1, \"free\", \"free\"]\nperiodic = true\n";
    return parse_problem(text.replace(text.find(asked), asked.size(), goal), "pair.toml");
  };
  const std::string bent = "rotation.a = [0, 0, 0]\nrotation.b = [0.0, 0.0, 0.8]\n";
  for (const auto& [goal, limits, key, fragment] :
       {std::tuple(bent, "angle.neck = [-0.6, 0.6]\n", "limits.angle.neck",
                   "found a goal that breaks this limit by 0.2 rad"),
        std::tuple(std::string("angle.neck = 0.8\n"), "angle.neck = [-0.6, 0.6]\n", "limits.angle.neck",
                   "found a goal that breaks this limit by 0.2 rad"),
        std::tuple(bent + "move = [0.0, 0.0, 0.5]\n", "half_space = [{ point = [0, 0, 0.3], normal = [0, 0, -1] }]\n",
                   "limits.half_space[0]", "found a goal that breaks this limit of a by "),
        std::tuple(bent + "move = [\"free\", \"free\", 0.5]\n",
                   "half_space = [{ point = [0, 0, 0.3], normal = [0, 0, -1] }]\n", "limits.half_space[0]",
                   "found a goal")}) {
    try {
      file::require_ends_within_limits(problem(goal, limits));
      ADD_FAILURE() << limits << " was taken as kept";
    } catch (const InputError& error) {
      EXPECT_EQ(error.key, key) << error.what();
      EXPECT_NE(error.message.find(fragment), std::string::npos) << error.what();
    }
  }
  EXPECT_NO_THROW(file::require_ends_within_limits(problem(bent, "angle.neck = [-0.6, 0.9]\n")));
  EXPECT_NO_THROW(
      file::require_ends_within_limits(problem("rotation.b = [0.0, 0.0, 0.8]\n", "angle.neck = [-0.6, 0.6]\n")))
      << "the joint's angle is free";
}

TEST(ProblemLimits, of_rates_of_angles_that_no_joint_has_are_refused) {
  std::string text = tests::bytes_of(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml") +
                     "\n[limits]\nangular_velocity_component = 3.0\n";
  try {
    parse_problem(text, "balls.toml");
    FAIL() << "a limit that limits nothing";
  } catch (const InputError& error) {
    EXPECT_EQ(error.key, "limits.angular_velocity_component");
    EXPECT_NE(error.message.find("limits.angular_velocity"), std::string::npos) << error.what();
  }
}

// However it is turned, a body reaches from its mass centre at least as far as its smallest semi-axis.
TEST(KeepOut, of_ends_and_waypoints_that_no_attitude_keeps_is_told_before_any_search) {
  const std::string three = tests::bytes_of(LAMPREY_SOURCE_DIR "/bench/problems/three_hinges.toml");
  const auto refused = [&](const std::string& more, const std::string& move) -> std::string {
    std::string text = three + more;
    const std::string old = "move = [0.05, \"free\", \"free\"]";
    text.replace(text.find(old), old.size(), "move = " + move);
    const std::string turn = "turn = [0.0, 0.0, 0.0]\n";
    text.replace(text.find(turn), turn.size(), "");
    try {
      file::require_ends_within_limits(parse_problem(text, "kept_out.toml"));
    } catch (const InputError& error) {
      EXPECT_NE(error.message.find("0.03 m before it"), std::string::npos) << error.what();
      return error.key;
    }
    return "";
  };
  const std::string wall = "\n[limits]\nhalf_space = [{ point = [0.0, 0.2, 0.0], normal = [0.0, -3.0, 0.0] }]\n";
  const std::string ball = "\n[limits]\nsphere = [{ centre = [0.0, 1.0, 0.0], radius = 0.5 }]\n";
  const auto by = [](const std::string& y) {
    return "[[waypoint]]\ntime = 1.0\nmove = [\"free\", " + y + ", \"free\"]\n";
  };
  const std::string anywhere = "[0.05, \"free\", \"free\"]";
  EXPECT_EQ(refused(wall, "[\"free\", 0.18, \"free\"]"), "goal.move");
  EXPECT_EQ(refused(wall, "[\"free\", 0.165, \"free\"]"), "");
  EXPECT_EQ(refused(wall + by("0.3"), anywhere), "waypoint[0].move");
  EXPECT_EQ(refused(wall + by("0.165"), anywhere), "");
  EXPECT_EQ(refused(ball, "[0.0, 0.48, 0.0]"), "goal.move");
  EXPECT_EQ(refused(ball, "[\"free\", 0.48, 0.0]"), "") << "it may pass beside the ball";
  EXPECT_EQ(refused(ball, "[0.0, 0.48, \"free\"]"), "goal.move") << "nothing takes it out of its plane";
  EXPECT_EQ(refused(ball + "[[waypoint]]\ntime = 1.0\nmove = [0.0, 0.48, \"free\"]\n", anywhere), "waypoint[0].move");
}

TEST(UnsupportedProblem, momentum_goes_into_no_gait) {
  const std::string drifting = "[start]\nlinear_velocity = [0.1, 0.0, 0.0]\n";
  const auto refused = [](const std::string& text) {
    const file::ProblemFile problem = parse_problem(text, "drifting.toml");
    try {
      file::require_supported(problem, file::Purpose::solve);
    } catch (const InputError& error) {
      EXPECT_EQ(error.key, "start");
      EXPECT_NE(task::check_task(problem).find("Not for lamprey solve"), std::string::npos);
      return true;
    }
    return false;
  };
  std::string text = tests::bytes_of(LAMPREY_SOURCE_DIR "/bench/problems/three_hinges.toml");
  text.replace(text.find("[start]\n"), 8, drifting);
  text.replace(text.find("[goal]\n"), 7, "[goal]\nrest = false\n");
  EXPECT_FALSE(refused(text));
  std::string gait = text, free = text;
  gait.replace(gait.find("rest = false"), 12, "periodic = true");
  free.replace(free.find("duration = 2.0"), 14, "duration = \"free\"\nmin = 1.0\nmax = 3.0");
  EXPECT_TRUE(refused(gait));
  EXPECT_FALSE(refused(free));
}

TEST(UnsupportedProblem, each_feature_is_refused_at_its_place_until_none_is_left) {
  const std::string path = "all.toml";
  std::string text = tests::bytes_of(tests::folder_of_tests() + "valid.toml");
  const auto replace = [&](const std::string& old, const std::string& with) {
    text.replace(text.find(old), old.size(), with);
  };
  auto purpose = file::Purpose::solve;
  const auto expect_key = [&](const std::string& key, const std::string& mark) {
    try {
      file::require_supported(parse_problem(text, path), purpose);
      FAIL() << key << " was taken as supported";
    } catch (const InputError& error) {
      EXPECT_EQ(error.key, key) << error.what();
      const auto before = text.substr(0, text.find(mark));
      EXPECT_EQ(error.line, 1 + std::count(before.begin(), before.end(), '\n')) << error.what();
      EXPECT_NE(error.message.find("this version seeks no maneuvers"), std::string::npos) << error.what();
    }
  };
  purpose = file::Purpose::solve_with_ipopt;  // it takes ball joints alone
  const std::string whole = text;
  expect_key("body[0].coupling_matrix", "coupling_matrix");
  replace("coupling_matrix = [[0.0, 0.1, 0.0], [0.2, 0.0, 0.0], [0.0, 0.0, -0.3]]\n", "");
  expect_key("joint[0].stiffness", "stiffness");
  replace("stiffness = 2.0\n", "");
  expect_key("joint[0].damping", "damping");
  replace("damping = 0.5\n", "");
  expect_key("joint[1].kind", "kind = \"hinge\"");
  replace("\"hinge\"", "\"ball\"");
  replace("axis = [0.0, 0.0, 2.0]\n", "");
  replace("angle.back = [-0.5, 1.5]\n", "");
  replace("angle.tail = [[-0.4, 0.4], [-1.0, 0.5]]\n", "");
  replace("angular_velocity_component = { back = 11.0, tail = 9.0 }\n", "");
  expect_key("joint[2].kind", "kind = \"universal\"");
  replace("\"universal\"", "\"ball\"");
  replace("axes = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]\n", "");
  expect_key("integrator.scheme", "scheme");
  replace("\"midpoint\"", "\"trapezoid\"");
  expect_key("limits.torque.neck", "torque.neck");
  replace("torque.neck = 1500.0\n", "");
  expect_key("limits.swing.neck", "swing.neck");
  replace("swing.neck = 1.0\n", "");
  expect_key("limits.twist.neck", "twist.neck");
  replace("twist.neck = 0.5\n", "");
  expect_key("limits.torque_component", "torque_component");
  replace("torque_component = 900.0\n", "");
  expect_key("limits.angular_velocity.back", "angular_velocity.back = 12.0");
  replace("angular_velocity.back = 12.0\n", "");
  expect_key("limits.sphere", "[[limits.sphere]]");
  replace("[[limits.sphere]]\ncentre = [4.0, 3.0, -1.0]\nradius = 0.75\n", "");
  expect_key("limits.half_space", "[[limits.half_space]]");
  replace("[[limits.half_space]]\npoint = [0.0, 0.0, -5.0]\nnormal = [0.0, 0.5, 2.0]\n", "");
  expect_key("limits.clearance", "clearance");
  replace("clearance = 0.1\n", "");
  expect_key("time.duration", "duration");
  replace("duration = \"free\"\nmin = 0.5\nmax = 2.5", "duration = 1.0");
  expect_key("goal.periodic", "periodic");
  text = whole;
  purpose = file::Purpose::solve;  // any joint and every scheme of one stage, with moments at the nodes
  replace("kind = \"spline\"", "kind = \"steps\"");
  if (text.find("points = ") != std::string::npos) {
    const auto points = text.find("points = ");
    text.erase(points, text.find('\n', points) + 1 - points);
  }
  replace("rule = \"rectangle\"\n", "");
  replace("method = \"shooting\"\n", "");
  for (const char* line : {"angular_velocity.front = [0.1, 0.2, 0.3]\n", "angular_velocity.middle = [0.0, 0.0, 0.5]\n",
                           "angular_velocity.back = [0.0, 0.0, 0.75]\n", "linear_velocity = [0.5, 0.0, 0.0]\n"})
    replace(line, "");  // from a start without momentum
  EXPECT_NO_THROW(file::require_supported(parse_problem(text, path), file::Purpose::solve));
}

TEST(UnsupportedProblem, coupled_inertia_is_refused_where_ipopt_is_to_solve_alone) {
  std::string text = tests::bytes_of(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  const auto insert = [&](const std::string& behind, const std::string& what) {
    text.insert(text.find('\n', text.find(behind)), "\n" + what);
  };
  insert("name = \"middle\"", "coupling_matrix = [[0.0, 0.1, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]");
  EXPECT_NO_THROW(file::require_supported(parse_problem(text, "coupled.toml"), file::Purpose::solve));
  try {
    file::require_supported(parse_problem(text, "coupled.toml"), file::Purpose::solve_with_ipopt);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.key, "body[0].coupling_matrix") << error.what();
    EXPECT_NE(error.message.find("without --solver ipopt"), std::string::npos) << error.what();
  }
  insert("[start]", "linear_velocity = [0.5, 0.0, 0.0]");
  text.replace(text.find("rest = true"), 11, "rest = false");
  EXPECT_NO_THROW(file::require_supported(parse_problem(text, "coupled.toml"), file::Purpose::solve));
}

TEST(UnsupportedProblem, an_error_that_knows_only_a_key_gets_the_place_of_the_nearest_enclosing_key) {
  const auto file = file::read_problem_file(tests::folder_of_tests() + "valid.toml");
  EXPECT_EQ(file::located(InputError("time.steps", "x"), file).line, file.positions.at("time.steps").line);
  EXPECT_EQ(file::located(InputError("body[1].mass", "x"), file).line, file.positions.at("body[1]").line);
  EXPECT_EQ(file::located(InputError("nowhere.at.all", "x"), file).line, 1);
}

}  // namespace
}  // namespace lamprey
