#include "result/sampled_functions.hpp"

#include <memory>
#include <vector>

#include "maneuver/control_path.hpp"

namespace lamprey::result {

maneuver::ControlFunction control_function(const ControlSamples& samples, const model::System& system) {
  std::vector<mechanics::Moments> moments;
  for (const auto& on_parent : samples.control) moments.push_back(maneuver::moments_at_zero_angle(system, on_parent));
  if (samples.source == ControlSource::stages)
    return maneuver::stage_polynomials(samples.time, moments, samples.stages);
  const int joints = system.joint_count();
  Eigen::MatrixXd values(3 * joints, static_cast<Eigen::Index>(samples.time.size()));
  for (std::size_t s = 0; s < samples.time.size(); ++s)
    for (int j = 0; j < joints; ++j)
      values.col(static_cast<Eigen::Index>(s)).segment<3>(3 * j) = moments[s][static_cast<std::size_t>(j)];
  const Eigen::VectorXd times =
      Eigen::Map<const Eigen::VectorXd>(samples.time.data(), static_cast<Eigen::Index>(samples.time.size()));
  const maneuver::ControlPath path =
      samples.source == ControlSource::spline
          ? maneuver::natural_spline_through_nodes(samples.points, times, values)
          : maneuver::ControlPath(samples.source == ControlSource::table ? maneuver::Interpolation::not_a_knot_cubic
                                                                         : maneuver::Interpolation::linear,
                                  times, values);
  return [path, joints](double t) {
    const Eigen::VectorXd u = path.value(t);
    mechanics::Moments at_time;
    for (int j = 0; j < joints; ++j) at_time.emplace_back(u.segment<3>(3 * j));
    return at_time;
  };
}

guess::JointAngles angle_function(const AngleSamples& samples) {
  const auto joints = static_cast<Eigen::Index>(samples.angle.front().size());
  Eigen::MatrixXd values(3 * joints, static_cast<Eigen::Index>(samples.time.size()));
  for (std::size_t s = 0; s < samples.time.size(); ++s)
    for (Eigen::Index j = 0; j < joints; ++j)
      values.col(static_cast<Eigen::Index>(s)).segment<3>(3 * j) = samples.angle[s][static_cast<std::size_t>(j)];
  const auto path = std::make_shared<const maneuver::ControlPath>(
      maneuver::Interpolation::not_a_knot_cubic,
      Eigen::Map<const Eigen::VectorXd>(samples.time.data(), static_cast<Eigen::Index>(samples.time.size())), values);
  const auto by_joint = [joints](const Eigen::VectorXd& all) {
    maneuver::Vectors each;
    for (Eigen::Index j = 0; j < joints; ++j) each.emplace_back(all.segment<3>(3 * j));
    return each;
  };
  return {[path, by_joint](double t) { return by_joint(path->value(t)); },
          [path, by_joint](double t) { return by_joint(path->slope(t)); }, samples.passive};
}

}  // namespace lamprey::result
