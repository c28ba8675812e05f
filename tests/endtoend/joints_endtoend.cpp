// Swimmers with led joints, springs, dampers and coupled inertia, from the problem file to the result.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "certificate/certify.hpp"
#include "integrator/scheme.hpp"
#include "lie/so3.hpp"
#include "program.hpp"
#include "result/resolve.hpp"
#include "result/solution_file.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using maneuver::Status;
using result::Results;

constexpr double degree = M_PI / 180.0;

std::string controls(const std::string& name) {
  return std::string(LAMPREY_SOURCE_DIR) + "/examples/" + name + "_controls.csv";
}

Results simulated(const Folder& folder, const std::string& problem, const std::string& options) {
  const ProgramRun run = lamprey(folder, "simulate " + problem + " " + options + " --out " + (folder / "run"));
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  return result::read_solution(folder / "run");
}

Results simulated_example(const Folder& folder, const std::string& name) {
  return simulated(folder, example(name), "--controls " + controls(name));
}

// World positions of all mass centres at a node, weighted by mass, m.
Vector3d centre_of_the_whole(const Results& results, std::size_t node) {
  const model::System system(result::swimmer_of(results.problem));
  const auto centres = system.mass_centres(results.solution.rotation[node], results.solution.position[node]);
  Vector3d sum = Vector3d::Zero();
  double mass = 0.0;
  for (int i = 0; i < system.body_count(); ++i) {
    sum += system.body(i).mass * centres[static_cast<std::size_t>(i)];
    mass += system.body(i).mass;
  }
  return sum / mass;
}

struct Largest {
  double linear = 0.0;   // kg m/s
  double angular = 0.0;  // kg m²/s
};

// Largest momentum of the root's translation; largest of any body's rotation and of all bodies about the origin.
Largest scale(const Results& results) {
  Largest largest;
  for (std::size_t k = 0; k < results.solution.time.size(); ++k) {
    const auto& bodies = results.problem.bodies;
    largest.linear = std::max(largest.linear, (bodies[0].mass_matrix * results.solution.linear_velocity[k]).norm());
    largest.angular = std::max(largest.angular, results.solution.angular_momentum.bodies[k].norm());
    for (std::size_t i = 0; i < bodies.size(); ++i)
      largest.angular =
          std::max(largest.angular, (bodies[i].inertia_matrix * results.solution.angular_velocity[k][i]).norm());
  }
  return largest;
}

void expect_momentum_kept(const Results& results, double allowed = 1e-12) {
  Largest drift;
  const auto& linear = results.solution.linear_momentum.total;
  const auto& angular = results.solution.angular_momentum.total;
  for (std::size_t k = 0; k < linear.size(); ++k) {
    drift.linear = std::max(drift.linear, (linear[k] - linear[0]).norm());
    drift.angular = std::max(drift.angular, (angular[k] - angular[0]).norm());
  }
  const Largest unit = scale(results);
  EXPECT_LE(drift.linear, tolerance(allowed) * unit.linear);
  EXPECT_LE(drift.angular, tolerance(allowed) * unit.angular);
}

// What the joints hold together, at every node: a hinge's axis in both bodies, the right angle of a universal joint's two.
double largest_misfit(const Results& results) {
  double misfit = 0.0;
  for (const auto& R : results.solution.rotation)
    for (const result::ResolvedJoint& joint : results.problem.joints) {
      const Matrix3d& parent = R[static_cast<std::size_t>(joint.parent)];
      const Matrix3d& child = R[static_cast<std::size_t>(joint.child)];
      if (joint.kind == model::JointKind::hinge)
        misfit = std::max(misfit,
                          (child * *joint.axis - parent * (lie::exp(joint.reference_rotation) * *joint.axis)).norm());
      if (joint.kind == model::JointKind::universal)
        misfit = std::max(misfit, std::abs((parent * (*joint.axes)[0]).dot(child * (*joint.axes)[1])));
      if (joint.kind == model::JointKind::fixed)
        misfit = std::max(misfit, (child - parent * lie::exp(joint.reference_rotation)).norm());
    }
  return misfit;
}

void expect_verified(const Folder& folder) {
  const ProgramRun run = lamprey(folder, "verify " + (folder / "run"));
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  // of divided steps files do not hold all
  const Results results = result::read_solution(folder / "run");
  const bool known = results.solution.divided.steps == 0;
  EXPECT_NE(run.out.find(known ? ", holds.\n" : ", is not refuted: "), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("✗"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("✓ Momentum drift"), std::string::npos) << run.out;
}

// Simulated, total momentum kept, verified from its files, joints in place.
Results sound_example(const Folder& folder, const std::string& name) {
  const Results results = simulated_example(folder, name);
  expect_momentum_kept(results);
  expect_verified(folder);
  EXPECT_LE(largest_misfit(results), tolerance(1e-12));
  return results;
}

TEST(FallingCat, turns_by_half_a_turn_at_zero_angular_momentum_and_straightens) {
  const Folder folder;
  const Results results = sound_example(folder, "falling_cat");
  const auto& first = results.solution.rotation.front();
  const auto& last = results.solution.rotation.back();
  double most_bent = 0.0;
  for (const auto& R : results.solution.rotation)
    most_bent = std::max(most_bent, lie::rotation_angle(R[0].transpose() * R[1]));
  EXPECT_GT(most_bent, 60.0 * degree);
  EXPECT_LT(lie::rotation_angle(last[0].transpose() * last[1]), 1e-6);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_GT(lie::rotation_angle(last[i] * first[i].transpose()), 179.0 * degree);
    EXPECT_GT(last[i](0, 0), 0.9999) << "its long axis points where it did";
  }
  EXPECT_LT((centre_of_the_whole(results, 700) - centre_of_the_whole(results, 0)).norm(), tolerance(1e-12));
  ASSERT_EQ(results.solution.control_stages.size(), 700U);
  EXPECT_EQ(results.solution.control_stages[0].size(),
            integrator::composition(integrator::Scheme::order4).fractions.size() + 1);
  EXPECT_TRUE(std::isnan(results.solution.cost));
}

TEST(FallingCat, follows_the_moments_of_its_own_result) {
  const Folder folder;
  for (const std::string scheme : {"trapezoid", "order4", "order6"}) {
    SCOPED_TRACE(scheme);
    const std::string options = " --steps 100 --scheme " + scheme;
    const Results once = simulated(folder, example("falling_cat"), "--controls " + controls("falling_cat") + options);
    std::filesystem::remove_all(folder / "first");
    std::filesystem::rename(folder / "run", folder / "first");
    const Results again =
        simulated(folder, example("falling_cat"), "--controls " + (folder / "first/solution.json") + options);
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_LE((once.solution.rotation.back()[i] - again.solution.rotation.back()[i]).norm(), tolerance(1e-10));
    EXPECT_GT(lie::rotation_angle(once.solution.rotation[50][0].transpose() * once.solution.rotation[50][1]), 0.5);
  }
}

// Moments between the nodes of an order-4 result run as polynomials: half the steps find nearly the same motion.
TEST(FallingCat, moments_between_the_nodes_of_a_result_of_order_4_are_those_of_its_stages) {
  const Folder folder;
  const Results fine = simulated(folder, example("falling_cat"), "--steps 200 --controls " + controls("falling_cat"));
  std::filesystem::rename(folder / "run", folder / "fine");
  const Results finer =
      simulated(folder, example("falling_cat"), "--steps 400 --controls " + (folder / "fine/solution.json"));
  EXPECT_LE((fine.solution.rotation.back()[0] - finer.solution.rotation.back()[0]).norm(), 1e-4);
}

TEST(Eel, swims_forward_by_a_third_of_its_length_at_zero_momentum) {
  const Folder folder;
  const Results results = sound_example(folder, "eel");
  const double length = 10 * 0.104;  // m
  const Vector3d way = centre_of_the_whole(results, 2400) - centre_of_the_whole(results, 0);
  EXPECT_GT(way.x(), 0.3 * length) << "forward";
  EXPECT_LT(std::abs(way.y()), 0.02 * length);
}

TEST(HingeFins, turn_the_body_by_beating_out_of_step) {
  const Folder folder;
  const Results results = sound_example(folder, "hinge_fins");
  const Vector3d turn = lie::log(results.solution.rotation.back()[0]);
  EXPECT_GT(turn.z(), 18.0 * degree);
  EXPECT_GT(std::abs(centre_of_the_whole(results, 1200).y()), 0.008);
}

TEST(ThreeLinks, go_round_a_loop_of_shapes_as_far_each_time) {
  const Folder folder;
  const std::string angles = "--angles " LAMPREY_SOURCE_DIR "/examples/three_links_angles.csv";
  const Results once = simulated(folder, example("three_links"), angles);
  expect_verified(folder);
  EXPECT_NEAR(once.solution.position.back().x(), -0.02235, 1e-5);
  const Results often = simulated(folder, example("three_links"), angles + " --cycles 4");
  EXPECT_NEAR(often.solution.time.back(), 4.0, 1e-12);
  EXPECT_LE((often.solution.position.back() - 4.0 * once.solution.position.back()).norm(), 1e-5);
  const Results again = simulated(folder, example("three_links"),
                                  "--angles " + (folder / "run") + "/solution.json --duration 4 --steps 800");
  EXPECT_LE((again.solution.position.back() - often.solution.position.back()).norm(), tolerance(1e-10));
}

// Of ball joints with one control axis each, in the plane.
TEST(AnglesOfAGait, are_all_that_its_motion_takes) {
  const Folder folder;
  ASSERT_EQ(lamprey(folder, "solve " + example("gait") + " --no-refinement --out " + (folder / "gait")).exit_code, 0);
  const Results gait = result::read_solution(folder / "gait");
  const Results along = simulated(folder, example("gait"), "--angles " + (folder / "gait") + "/solution.json");
  expect_verified(folder);
  ASSERT_EQ(along.solution.time.size(), gait.solution.time.size());
  double largest = 0.0, off = 0.0;
  for (std::size_t k = 0; k < gait.solution.time.size(); ++k) {
    EXPECT_LE((along.solution.position[k] - gait.solution.position[k]).norm(), tolerance(1e-9)) << k;
    for (std::size_t j = 0; j < 2 && k > 0 && k + 1 < gait.solution.time.size(); ++j) {
      largest = std::max(largest, gait.solution.control[k][j].norm());
      off = std::max(off, (along.solution.control[k][j] - gait.solution.control[k][j]).norm());
    }
  }
  EXPECT_LE(off, tolerance(1e-7) * largest);
}

TEST(ThreeLinks, are_told_what_their_stroke_costs_and_free_bodies_nothing) {
  const Folder folder;
  const std::string out = " --out " + (folder / "run");
  const std::string stroke = lamprey(folder, "simulate " + example("three_links") + out + " --angles " +
                                                 LAMPREY_SOURCE_DIR "/examples/three_links_angles.csv")
                                 .out;
  EXPECT_NE(stroke.find("Work of the joints"), std::string::npos) << stroke;
  EXPECT_NE(stroke.find("Cost of transport"), std::string::npos) << stroke;
  std::filesystem::rename(folder / "run" + std::string("/solution.json"), folder / "stroke.json");
  const std::string again =
      lamprey(folder, "simulate " + example("three_links") + out + " --controls " + (folder / "stroke.json")).out;
  EXPECT_NE(again.find("a motion that began otherwise"), std::string::npos) << again;
  const std::string free = lamprey(folder, "simulate " + example("tumble") + " --steps 100 --duration 0.1" + out).out;
  EXPECT_EQ(free.find("Work of the joints"), std::string::npos) << free;
}

TEST(ThreeLinks, are_told_what_a_march_along_angles_cannot_do) {
  const Folder folder;
  const std::string march = "simulate " + example("three_links") + " --out " + (folder / "run") + " --angles " +
                            LAMPREY_SOURCE_DIR "/examples/three_links_angles.csv ";
  EXPECT_EQ(lamprey(folder, march + "--scheme order4").exit_code, 3);
  EXPECT_NE(lamprey(folder, march + "--scheme order4").err.find("found order4; allowed where a march follows"),
            std::string::npos);
  EXPECT_EQ(lamprey(folder, march + "--adaptive").exit_code, 2);
  EXPECT_EQ(lamprey(folder, march + "--reference").exit_code, 2);
  EXPECT_NE(
      lamprey(folder, march + "--duration 3").err.find("found angles from 0 s to 1 s; allowed: those of the whole"),
      std::string::npos);
}

// Fins without controls, carried along by a body that starts in motion.
TEST(HingeFins, tumble_with_their_body_in_every_scheme_and_stay_on_their_hinges) {
  const Folder folder;
  std::string text = text_of(example("hinge_fins"));
  text += "\n[start]\nangular_velocity.body = [0.8, -0.5, 1.1]\nlinear_velocity = [0.2, -0.1, 0.3]\n";
  std::ofstream(folder / "problem.toml") << text;
  for (const std::string scheme : {"paper", "trapezoid", "midpoint", "order4", "order6"}) {
    SCOPED_TRACE(scheme);
    const Results results = simulated(folder, folder / "problem.toml", "--steps 600 --duration 3 --scheme " + scheme);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LE((results.solution.angular_velocity[0][i] - Vector3d(0.8, -0.5, 1.1)).norm(), tolerance(1e-14))
          << "fins that say nothing start with the body";
    EXPECT_GT(lie::rotation_angle(results.solution.rotation.back()[0]), 0.5);
    expect_momentum_kept(results);
    expect_verified(folder);
    EXPECT_LE(largest_misfit(results), tolerance(1e-12));
  }
}

TEST(Coupling, of_inertia_is_read_marched_written_and_verified) {
  const Folder folder;
  std::string text = text_of(example("tumble"));
  const std::string mark = "semi_axes = [8.0, 1.5, 2.0]";
  text.replace(text.find(mark), mark.size(),
               "coupling_matrix = [[0.1, 0.0, 0.2], [0.0, -0.3, 0.0], [0.1, 0.2, 0.0]]\n" + mark);
  std::ofstream(folder / "problem.toml") << text;
  const Results coupled = simulated(folder, folder / "problem.toml", "--steps 500 --duration 0.5 --scheme midpoint");
  expect_momentum_kept(coupled);
  expect_verified(folder);
  EXPECT_EQ(coupled.problem.bodies[0].coupling_matrix(1, 1), -0.3);
  const Results plain = simulated(folder, example("tumble"), "--steps 500 --duration 0.5 --scheme midpoint");
  EXPECT_GT((coupled.solution.rotation.back()[0] - plain.solution.rotation.back()[0]).norm(), 1e-3);
}

TEST(FailingStep, ends_the_march_with_its_time_its_residual_and_a_step_that_works) {
  const Folder folder;
  const std::string few_steps = "simulate " + example("tumble") + " --steps 4 --duration 2 --out " + (folder / "run");
  const ProgramRun run = lamprey(folder, few_steps);
  EXPECT_EQ(run.exit_code, 5) << run.out << run.err;
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  for (const char* part :
       {"step 0 at t = 0 s did not converge", "residual", "Newton iterations", "; a step of ", "--adaptive"})
    EXPECT_NE(run.err.find(part), std::string::npos) << part << " is missing from " << run.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "run"));

  std::smatch found;
  const std::regex shorter("; a step of ([-.e0-9]+) s works from there: try ([0-9]+) steps");
  ASSERT_TRUE(std::regex_search(run.err, found, shorter)) << run.err;
  EXPECT_LT(std::stod(found[1]), 0.5);
  const ProgramRun adaptive = lamprey(folder, few_steps + " --adaptive");
  EXPECT_EQ(adaptive.exit_code, 0) << adaptive.out << adaptive.err;
  EXPECT_NE(adaptive.out.find("divided into"), std::string::npos) << adaptive.out;
  const Results results = result::read_solution(folder / "run");
  EXPECT_EQ(results.solution.time.size(), 5U);
  EXPECT_GE(results.solution.divided.steps, 1);
  EXPECT_GE(results.solution.divided.substeps, 2 * results.solution.divided.steps);
  EXPECT_LE(results.solution.divided.smallest_step, std::stod(found[1]) * 1.001);
  expect_momentum_kept(results);
  expect_verified(folder);
}

// With a quarter of the steps the eel's stiff springs are too fast for some; pieces of them, and the moments within, find
// the same motion.
TEST(FailingStep, divided_gives_the_motion_of_small_steps) {
  const Folder folder;
  const std::string few_steps =
      "simulate " + example("eel") + " --controls " + controls("eel") + " --steps 600 --out " + (folder / "run");
  const ProgramRun ended = lamprey(folder, few_steps);
  EXPECT_EQ(ended.exit_code, 5);
  EXPECT_NE(ended.err.find("what it came to, up to "), std::string::npos) << ended.err;
  const Results part = result::read_solution(folder / "run");
  EXPECT_EQ(part.solution.status, maneuver::Status::stalled);
  EXPECT_GT(part.solution.time.size(), 1U);
  ASSERT_EQ(lamprey(folder, few_steps + " --adaptive").exit_code, 0);
  const Results divided = result::read_solution(folder / "run");
  EXPECT_GE(divided.solution.divided.steps, 1);
  EXPECT_LT(divided.solution.divided.steps, 300) << "each step begins whole";
  expect_momentum_kept(divided);
  expect_verified(folder);
  const Results fine = simulated_example(folder, "eel");
  EXPECT_LT((centre_of_the_whole(divided, 600) - centre_of_the_whole(fine, 2400)).norm(), 0.005);
}

TEST(FailingStep, divided_leaves_moments_at_the_stages_of_the_whole_step) {
  const Folder folder;
  const Results results = simulated(folder, example("tumble"), "--scheme order4 --steps 1 --duration 2 --adaptive");
  EXPECT_EQ(results.solution.divided.steps, 1);
  ASSERT_EQ(results.solution.control_stages.size(), 1U);
  EXPECT_EQ(results.solution.stage_time[0].front(), 0.0);
  EXPECT_EQ(results.solution.stage_time[0].back(), 2.0);
  expect_momentum_kept(results);
}

std::string fins_with_a_goal() {
  std::string text = text_of(example("hinge_fins"));
  const auto replace = [&](const std::string& old, const std::string& with) {
    for (auto n = text.find(old); n != std::string::npos; n = text.find(old, n + with.size()))
      text.replace(n, old.size(), with);
  };
  replace("duration = 6.0", "duration = 2.0");
  replace("steps = 1200", "steps = 400");
  replace("stiffness = 5.0", "stiffness = 0.5");
  replace("damping = 0.5", "damping = 0.05");
  return text + "\n[goal]\nturn = [0.0, 0.0, 0.1]\n";
}

TEST(LedJoints, with_springs_and_dampers_find_their_maneuver_and_prove_it) {
  const Folder folder;
  std::ofstream(folder / "problem.toml") << fins_with_a_goal();
  const ProgramRun run = lamprey(folder, "solve " + (folder / "problem.toml") + " --out " + (folder / "run"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const Results results = result::read_solution(folder / "run");
  EXPECT_EQ(results.solution.status, maneuver::Status::optimal) << results.solution.message;
  EXPECT_LE(largest_misfit(results), tolerance(1e-12));
  expect_momentum_kept(results);
  expect_verified(folder);
  const Vector3d turn = lie::log(results.solution.rotation.back()[0]);
  EXPECT_LE((turn - Vector3d(0.0, 0.0, 0.1)).norm(), tolerance(1e-9));
}

// By equations of its own (5.16), from another solver's answer and from its own first guess.
TEST(LedJoints, with_springs_and_dampers_cost_the_same_by_the_other_solver) {
  const Folder folder;
  std::string text = fins_with_a_goal();
  text.replace(text.find("\"midpoint\""), 10, "\"trapezoid\"");
  std::ofstream(folder / "problem.toml") << text;
  const auto solved = [&](const std::string& options, const char* to) {
    const ProgramRun run = lamprey(
        folder, "solve " + (folder / "problem.toml") + " --no-refinement " + options + " --out " + (folder / to));
    EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
    return result::read_solution(folder / to);
  };
  const Results found = solved("", "run");
  const Results stayed = solved("--solver ipopt --first " + (folder / "run"), "stayed");
  EXPECT_EQ(stayed.solution.solver.name, "ipopt");
  EXPECT_NEAR(stayed.solution.cost / found.solution.cost, 1.0, tolerance(1e-8));
  EXPECT_EQ(stayed.certificate->verdict, certificate::Verdict::proved);
  EXPECT_EQ(solved("--solver ipopt", "cold").certificate->verdict, certificate::Verdict::proved);
}

TEST(BallJoints, with_springs_and_dampers_cost_the_same_by_the_other_solver) {
  const Folder folder;
  std::string text =
      text_of(varied_example(folder, "translation_in_space", {{"steps", "60"}, {"starts", "1"}, {"hops", "0"}}));
  text.insert(text.find('\n', text.find("kind = \"ball\"")), "\nstiffness = 20.0\ndamping = 3.0");
  std::ofstream(folder / "problem.toml") << text;
  const std::string solve = "solve --no-refinement " + (folder / "problem.toml");
  lamprey(folder, solve + " --out " + (folder / "run"));
  const Results found = result::read_solution(folder / "run");
  ASSERT_EQ(found.solution.status, maneuver::Status::optimal) << found.solution.message;
  const ProgramRun run =
      lamprey(folder, solve + " --solver ipopt --first " + (folder / "run") + " --out " + (folder / "stayed"));
  const Results stayed = result::read_solution(folder / "stayed");
  EXPECT_EQ(stayed.solution.status, maneuver::Status::optimal) << run.out << run.err;
  EXPECT_NEAR(stayed.solution.cost / found.solution.cost, 1.0, tolerance(1e-8));
}

// By the full transcription, where what joints hold are equations and moments of their own, with hops.
TEST(LedJoints, flip_the_cat_for_the_same_cost_by_the_other_solver) {
  const Folder folder;
  const std::string problem = varied_example(folder, "falling_cat_flip", {{"starts", "4\nhops = 2"}});
  const ProgramRun run = lamprey(folder, "solve --solver ipopt " + problem + " --out " + (folder / "run"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const Results results = result::read_solution(folder / "run");
  EXPECT_EQ(results.solution.solver.name, "ipopt");
  EXPECT_EQ(results.solution.search.hops, 2);
  EXPECT_NEAR(results.solution.cost / 0.16696594, 1.0, tolerance(1e-7));
  expect_verified(folder);
}

}  // namespace
}  // namespace lamprey::tests
