// fluid: the inertia of an ellipsoid.
#include <nanobind/nanobind.h>

#include "arrays.hpp"
#include "fluid/ellipse.hpp"
#include "model/input_error.hpp"
#include "module.hpp"

namespace lamprey::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

nb::dict ellipsoid_inertia(nb::handle semi_axes, double density) {
  fluid::EllipsoidInertia inertia;
  try {
    const Numbers given = numbers(semi_axes, "semi_axes");
    if (given.ndim() == 1 && given.shape(0) == 2)
      inertia = fluid::ellipse_inertia({given.data()[0], given.data()[1]}, density);
    else
      inertia = fluid::ellipsoid_inertia(three(semi_axes, "semi_axes", "half lengths (m)"), density);
  } catch (const std::invalid_argument& error) {
    throw model::InputError("semi_axes, density", error.what());
  }
  nb::dict words;
  words["volume"] = inertia.volume;
  words["mass"] = inertia.mass;
  words["body_inertia"] = array(inertia.body_inertia);
  words["added_mass"] = array(inertia.added_mass);
  words["added_inertia"] = array(inertia.added_inertia);
  words["mass_matrix"] =
      array(Eigen::Matrix3d((inertia.added_mass + Eigen::Vector3d::Constant(inertia.mass)).asDiagonal()));
  words["inertia_matrix"] = array(Eigen::Matrix3d((inertia.body_inertia + inertia.added_inertia).asDiagonal()));
  return words;
}

}  // namespace

void bind_fluid(nb::module_& module) {
  module.def(
      "ellipsoid_inertia", &ellipsoid_inertia, "semi_axes"_a, "density"_a,
      nb::sig("def ellipsoid_inertia(semi_axes: numpy.typing.ArrayLike, density: float) -> dict[str, typing.Any]"),
      "Inertia of a homogeneous, neutrally buoyant ellipsoid and of the fluid that it drags along.\n\n"
      "semi_axes: three half lengths, m, or two of an ellipse in the plane, of which one metre is meant. density: of "
      "the fluid, kg/m³; 0 is a vacuum.\n"
      "Returns a dict with the words of `lamprey inertia --json`, in the frame of the ellipsoid's own axes, about "
      "its centre:\n"
      "volume (m³), mass (kg), body_inertia (3,) kg m², added_mass (3,) kg, added_inertia (3,) kg m²,\n"
      "mass_matrix (3, 3) kg and inertia_matrix (3, 3) kg m², which are body and fluid together.\n"
      "InputError where a half length is no positive number or the density a negative one.");
}

}  // namespace lamprey::python
