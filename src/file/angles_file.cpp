#include "file/angles_file.hpp"

#include <utility>

#include <fmt/format.h>

#include "file/followed_file.hpp"
#include "file/solution_file.hpp"
#include "file/text_file.hpp"
#include "model/input_error.hpp"

namespace lamprey::file {

using model::InputError;

AngleSamples angles_of_results(const Results& results, const std::string& path, const Joints& joints) {
  require_motion_of(joints, results, path);
  if (results.solution.joint_angle.size() != results.solution.time.size())
    throw InputError(
        path, "/joint_angle",
        "found none; allowed: the angles at each node; write the file anew (lamprey simulate, lamprey solve)");
  return {results.solution.time, results.solution.joint_angle};
}

AngleSamples parse_angles(const std::string& bytes, const std::string& path, const Joints& joints) {
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && bytes[first] == '{')
    return angles_of_results(parse_solution(bytes, path), path, joints);
  JointTable table = parse_joint_table(TableKind::angles, bytes, path, joints);
  return {std::move(table.time), std::move(table.value), std::move(table.remark)};
}

AngleSamples read_angles(const std::string& path, const Joints& joints) {
  return parse_angles(read_bytes(path, table_byte_limit), path, joints);
}

void repeat(int cycles, const std::string& path, const Joints& joints, AngleSamples& angles) {
  constexpr double closed = 1e-6;  // rad, of a period's ends
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (const double open = (angles.angle.back()[j] - angles.angle.front()[j]).norm(); cycles > 1 && open > closed)
      throw InputError(path, joints[j].name,
                       fmt::format("found {:.3g} rad between its last and its first angle; allowed: none, where cycles "
                                   "repeat; end where it begins, or leave cycles out",
                                   open));
  const std::vector<double> time = angles.time;
  const auto angle = angles.angle;
  const double period = time.back() - time.front();
  for (int cycle = 1; cycle < cycles; ++cycle)
    for (std::size_t k = 1; k < time.size(); ++k) {
      angles.time.push_back(time[k] + cycle * period);
      angles.angle.push_back(angle[k]);
    }
}

}  // namespace lamprey::file
