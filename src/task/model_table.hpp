// What `lamprey check` and `lamprey inertia` print.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "maneuver/problem.hpp"
#include "model/system.hpp"

namespace lamprey::task {

/// The resolved model and the task in words: bodies, inertia, joints, neighbours' gaps at the start, goal, time, scheme,
/// search, and remarks on these. Needs start rotations for every body; the system must be that of the problem.
std::string model_table(const maneuver::Problem& problem, const model::System& system,
                        const std::vector<std::string>& remarks);

/// What is minimised, a term for each weight.
std::string cost_words(double effort, double time_weight, const maneuver::CostWeights& weights);

/// Inertia of one neutrally buoyant ellipsoid, or of one metre of an ellipse that has two semi-axes, for people to read: m, kg/m³.
/// Throws model::InputError for lengths or densities that make no body.
std::string inertia_table(const Eigen::VectorXd& semi_axes, double density);

/// The same as one JSON document: volume, mass, body_inertia, added_mass, added_inertia, mass_matrix, inertia_matrix.
std::string inertia_json(const Eigen::VectorXd& semi_axes, double density);

}  // namespace lamprey::task
