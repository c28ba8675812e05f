// What moments can do to a swimmer near a motion: which coordinates they move, which end conditions they can meet.
#pragma once

#include <optional>
#include <string>

#include "maneuver/end_rows.hpp"
#include "maneuver/node_path.hpp"

namespace lamprey::shape {

using Eigen::MatrixXd;
using maneuver::EndRow;
using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::ShapeCoordinates;

/// Coordinates that moments can move along a motion of a path's shapes and near it: fewer than all where symmetry keeps the
/// swimmer in a plane, say. Nothing where no motion with these shapes is found.
std::optional<ShapeCoordinates> reachable_coordinates(const model::System& system, const Maneuver& maneuver,
                                                      const NodePath& path);

/// Of the conditions a maneuver states those that moments along such a motion can meet independently: momentum conservation
/// and symmetry make others follow from them. Nothing where no motion with these shapes is found.
std::optional<std::vector<EndRow>> independent_end_rows(const model::System& system, const Maneuver& maneuver,
                                                        const ShapeCoordinates& coordinates, const NodePath& path);

/// How much total momentum takes a swimmer out of where moments move its root, as a share of its bodies' own: turns (rad) and
/// displacements (m), orthonormal columns. 0 where they move it in every way.
double momentum_beside(const model::System& system, const integrator::State& state, const MatrixXd& pose);
/// Total momentum, angular about the world's origin, without that.
mechanics::SpatialMomentum momentum_within(const model::System& system, const integrator::State& state,
                                           const MatrixXd& pose);

/// Why no motion meets the goal, or the places of waypoints, in words: it lies outside the plane or the line in which moments keep such a motion, or asks a
/// single coordinate, which can only go back the way it came where it cannot turn right round, for a displacement that ends in the first shape. Empty where neither shows, and
/// where momentum takes the swimmer out of that plane or line.
std::string out_of_reach(const model::System& system, const Maneuver& maneuver,
                         const std::vector<maneuver::Waypoint>& waypoints, const ShapeCoordinates& coordinates,
                         const NodePath& path);

/// model::InputError (cost.displacement, cost.transport) where such a single coordinate wins no displacement to pay for, or where the price is
/// along what no moment moves.
void refuse_price_of_no_displacement(const model::System& system, const Maneuver& maneuver,
                                     const ShapeCoordinates& coordinates);

/// All conditions a maneuver states of swimmers in such coordinates.
std::vector<EndRow> all_end_rows(const model::System& system, const Maneuver& maneuver,
                                 const ShapeCoordinates& coordinates);

}  // namespace lamprey::shape
