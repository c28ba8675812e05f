// Work–precision diagrams: error against processor time of every scheme and of Runge–Kutta and Euler methods on the
// continuous equations. Writes docs/images/work_precision.svg, energy_work.svg and energy_balance.svg into a folder.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "integrator/march.hpp"
#include "integrator/reference_integrator.hpp"
#include "lie/so3.hpp"
#include "mechanics/equations_of_motion.hpp"
#include "swimmers.hpp"

namespace lamprey::bench {

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using integrator::ReferenceState;
using integrator::Scheme;
using integrator::State;
using mechanics::Moments;
using model::at;

struct Point {
  double x, y;
};

struct Curve {
  std::string name;
  std::vector<Point> points;
  bool dashed;  // methods on the continuous equations
};

struct Diagram {
  std::string title, x_label, y_label, note;
  std::vector<Curve> curves;
};

// The chain of examples/tumble.toml.
struct Tumble {
  model::System system{paper_chain()};
  ReferenceState start;
  Moments none = Moments(2, Vector3d::Zero());

  Tumble() {
    VectorXd velocity(12);
    velocity << 0.6, -0.9, 1.2, 2.5, 1.0, -1.5, -2.0, 1.5, 1.0, 0.5, 0.2, -0.1;
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    start = {{I, I, lie::exp(Vector3d(0.0, 0.0, 0.25 * M_PI))}, Vector3d::Zero(), velocity};
  }
  State momentum_start() const {
    return integrator::state_of_velocity(system, start.rotation, start.position, start.velocity);
  }
  double energy(const mechanics::Rotations& R, const VectorXd& velocity) const {
    return mechanics::kinetic_energy(system, R, velocity);
  }
};

double distance(const mechanics::Rotations& a, const mechanics::Rotations& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]).squaredNorm();
  return std::sqrt(squares);
}

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Least processor time of several runs, s.
double least_time(const std::function<void()>& run) {
  double least = INFINITY, total = 0.0;
  for (int n = 0; n < 200 && (n < 3 || total < 0.2); ++n) {
    const double begin = processor_seconds();
    run();
    const double taken = processor_seconds() - begin;
    least = std::min(least, taken);
    total += taken;
  }
  return least;
}

using Watch = std::function<void(const mechanics::Rotations& rotation, const VectorXd& velocity)>;

// A method over a duration in so many steps (or at a tolerance); `watch` is shown every step, and may be empty.
using Method = std::function<mechanics::Rotations(double duration, double setting, const Watch& watch)>;

Method variational(const Tumble& tumble, Scheme scheme) {
  return [&tumble, scheme](double duration, double steps, const Watch& watch) {
    integrator::March march(tumble.system, scheme);
    State state = tumble.momentum_start();
    const integrator::StageControl none = [&](int) -> const Moments& { return tumble.none; };
    for (int k = 0; k < static_cast<int>(steps); ++k) {
      if (!march.advance(duration / steps, none, state).converged) return mechanics::Rotations();
      if (watch) watch(state.rotation, integrator::velocity_of_state(tumble.system, state));
    }
    return state.rotation;
  };
}

// Classical Runge–Kutta of order 4; rotations as quaternions, normalised after each step.
struct Flow {
  std::vector<lie::Vector4> quaternion;  // [bodies]
  Vector3d position;
  VectorXd velocity;

  static Flow of(const ReferenceState& state) {
    Flow flow{{}, state.position, state.velocity};
    for (const auto& R : state.rotation) flow.quaternion.push_back(lie::quaternion_of_rotation(R));
    return flow;
  }
  mechanics::Rotations rotations() const {
    mechanics::Rotations R;
    for (const auto& q : quaternion) R.push_back(lie::rotation_of_quaternion(q));
    return R;
  }
  Flow rate(const Tumble& tumble) const {
    Flow change{quaternion, velocity.tail<3>(), {}};
    const auto R = rotations();
    const auto Omega = mechanics::angular_velocities(tumble.system, R, velocity);
    for (std::size_t i = 0; i < quaternion.size(); ++i)
      change.quaternion[i] =
          0.5 * lie::quaternion_product(quaternion[i], {0.0, Omega[i].x(), Omega[i].y(), Omega[i].z()});
    change.velocity = mechanics::acceleration(tumble.system, R, velocity, tumble.none);
    return change;
  }
  Flow plus(double h, const Flow& change) const {
    Flow moved = *this;
    for (std::size_t i = 0; i < quaternion.size(); ++i) moved.quaternion[i] += h * change.quaternion[i];
    moved.position += h * change.position;
    moved.velocity += h * change.velocity;
    return moved;
  }
};

Method runge_kutta_4(const Tumble& tumble) {
  return [&tumble](double duration, double steps, const Watch& watch) {
    Flow y = Flow::of(tumble.start);
    const double h = duration / steps;
    for (int k = 0; k < static_cast<int>(steps); ++k) {
      const Flow k1 = y.rate(tumble), k2 = y.plus(0.5 * h, k1).rate(tumble), k3 = y.plus(0.5 * h, k2).rate(tumble),
                 k4 = y.plus(h, k3).rate(tumble);
      y = y.plus(h / 6.0, k1).plus(h / 3.0, k2).plus(h / 3.0, k3).plus(h / 6.0, k4);
      for (auto& q : y.quaternion) q.normalize();
      if (watch) watch(y.rotations(), y.velocity);
    }
    return y.rotations();
  };
}

// The Euler method of Crocoddyl's integrated action model: v' = v + h a, and the configuration moves on with v'.
Method euler(const Tumble& tumble) {
  return [&tumble](double duration, double steps, const Watch& watch) {
    ReferenceState state = tumble.start;
    const double h = duration / steps;
    for (int k = 0; k < static_cast<int>(steps); ++k) {
      state.velocity += h * mechanics::acceleration(tumble.system, state.rotation, state.velocity, tumble.none);
      for (int i = 0; i < 3; ++i) state.rotation[at(i)] *= lie::exp(h * state.velocity.segment<3>(3 * i));
      state.position += h * state.velocity.tail<3>();
      if (watch) watch(state.rotation, state.velocity);
    }
    return state.rotation;
  };
}

Method fehlberg(const Tumble& tumble) {
  return [&tumble](double duration, double tolerance, const Watch& watch) {
    ReferenceState state = tumble.start;
    integrator::ReferenceIntegrator reference(
        tumble.system, [&](double) { return tumble.none; }, tolerance);
    const int pieces = watch ? static_cast<int>(10.0 * duration) : 1;  // looked at ten times a second
    for (int k = 0; k < pieces; ++k) {
      if (!reference.advance(duration * k / pieces, duration * (k + 1) / pieces, state)) return mechanics::Rotations();
      if (watch) watch(state.rotation, state.velocity);
    }
    return state.rotation;
  };
}

struct Measured {
  std::string name;
  Method method;
  std::vector<double> over_1_s, over_100_s;  // steps, or tolerances
  bool dashed;
};

std::vector<Measured> methods(const Tumble& tumble) {
  const std::vector<double> low = {50, 100, 200, 400, 800, 1600, 3200}, low_100 = {5e3, 1e4, 2e4, 4e4, 8e4, 1.6e5};
  return {{"paper, order 1", variational(tumble, Scheme::paper), low, low_100, false},
          {"trapezoid, order 2", variational(tumble, Scheme::trapezoid), low, low_100, false},
          {"midpoint, order 2", variational(tumble, Scheme::midpoint), low, low_100, false},
          {"order4",
           variational(tumble, Scheme::order4),
           {15, 25, 50, 100, 200, 400, 800},
           {2e3, 4e3, 8e3, 1.6e4, 3.2e4},
           false},
          {"order6",
           variational(tumble, Scheme::order6),
           {10, 15, 25, 40, 60, 100, 150},
           {1.5e3, 2.5e3, 4e3, 8e3, 1.6e4},
           false},
          {"Euler, as Crocoddyl's", euler(tumble), low, low_100, true},
          {"Runge–Kutta 4",
           runge_kutta_4(tumble),
           {25, 50, 100, 200, 400, 800, 1600},
           {2.5e3, 5e3, 1e4, 2e4, 4e4, 8e4},
           true},
          {"Runge–Kutta–Fehlberg 7(8)",
           fehlberg(tumble),
           {1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13},
           {1e-4, 1e-6, 1e-8, 1e-10, 1e-12},
           true}};
}

Diagram work_precision(const Tumble& tumble, const mechanics::Rotations& truth) {
  Diagram diagram{"Error after 1 s of tumbling against processor time",
                  "processor time for 1 s of motion, s",
                  "error of the rotations, ‖R − R*‖, no unit",
                  "",
                  {}};
  for (const Measured& m : methods(tumble)) {
    Curve curve{m.name, {}, m.dashed};
    for (double setting : m.over_1_s) {
      const auto end = m.method(1.0, setting, {});
      if (end.empty()) continue;
      const double error = distance(end, truth);
      const double time = least_time([&] { m.method(1.0, setting, {}); });
      fmt::print("{:<28} {:>8g}  {:.3e} s  error {:.3e}\n", m.name, setting, time, error);
      if (error < 3.0) curve.points.push_back({time, error});
    }
    diagram.curves.push_back(curve);
  }
  return diagram;
}

Diagram energy_work(const Tumble& tumble) {
  Diagram diagram{"Energy error over 100 s of tumbling against processor time",
                  "processor time for 100 s of motion, s",
                  "largest energy error, relative",
                  "",
                  {}};
  const double first = tumble.energy(tumble.start.rotation, tumble.start.velocity);
  for (const Measured& m : methods(tumble)) {
    Curve curve{m.name, {}, m.dashed};
    for (double setting : m.over_100_s) {
      double largest = 0.0;
      const auto end = m.method(100.0, setting, [&](const mechanics::Rotations& R, const VectorXd& velocity) {
        const double error = std::abs(tumble.energy(R, velocity) / first - 1.0);
        largest = std::isfinite(error) ? std::max(largest, error) : INFINITY;
      });
      if (end.empty() || !(largest < 10.0)) continue;
      const double begin = processor_seconds();
      m.method(100.0, setting, {});
      const double time = processor_seconds() - begin;
      fmt::print("{:<28} {:>8g}  {:.3e} s  energy {:.3e}\n", m.name, setting, time, largest);
      curve.points.push_back({time, largest});
    }
    diagram.curves.push_back(curve);
  }
  return diagram;
}

// Change of energy less the joints' work over 1 s under smooth moments of some 30 N m.
double imbalance(const Tumble& tumble, Scheme scheme, int steps) {
  const auto moments_at = [](double t) {
    Moments u;
    for (int j = 0; j < 2; ++j)
      u.emplace_back(
          Vector3d(2.0 * std::sin(5.0 * t + j), 20.0 * std::cos(3.0 * t - j), 30.0 * std::sin(4.0 * t + 2.0 * j)));
    return u;
  };
  const model::System& system = tumble.system;
  State state = tumble.momentum_start();
  const auto power = [&](const State& s, const Moments& u) {
    return mechanics::generalized_force(system, s.rotation, u).dot(integrator::velocity_of_state(system, s));
  };
  const auto energy = [&] { return tumble.energy(state.rotation, integrator::velocity_of_state(system, state)); };
  integrator::March march(system, scheme);
  const double first = energy(), h = 1.0 / steps;
  double work = 0.0, largest = 0.0;
  for (int step = 0; step < steps; ++step) {
    std::vector<Moments> moments;
    for (double node : march.nodes()) moments.push_back(moments_at(h * (step + node)));
    double before = power(state, moments[0]);
    std::size_t stage = 0;
    const auto add_stage = [&](const mechanics::Interval&, const State& after) {
      const double now = power(after, moments[stage + 1]);
      work += 0.5 * h * integrator::composition(scheme).fractions[stage] * (before + now);
      before = now;
      ++stage;
    };
    if (!march
             .advance(
                 h, [&](int node) -> const Moments& { return moments[at(node)]; }, state, add_stage)
             .converged)
      return INFINITY;
    largest = std::max(largest, std::abs(energy() - first - work));
  }
  return largest;
}

Diagram energy_balance(const Tumble& tumble) {
  Diagram diagram{"Energy under control: change of energy less the joints' work, over 1 s",
                  "time step, s",
                  "largest |E − E(0) − work|, J",
                  "",
                  {}};
  const std::pair<const char*, Scheme> schemes[] = {{"paper, order 1", Scheme::paper},
                                                    {"trapezoid, order 2", Scheme::trapezoid},
                                                    {"midpoint, order 2", Scheme::midpoint},
                                                    {"order4", Scheme::order4},
                                                    {"order6", Scheme::order6}};
  for (const auto& [name, scheme] : schemes) {
    Curve curve{name, {}, false};
    for (int steps : {40, 60, 100, 160, 250, 400, 630, 1000}) {
      const double off = imbalance(tumble, scheme, steps);
      fmt::print("{:<28} h {:.3e} s  imbalance {:.3e} J\n", name, 1.0 / steps, off);
      if (off < 100.0) curve.points.push_back({1.0 / steps, off});
    }
    diagram.curves.push_back(curve);
  }
  return diagram;
}

// Both axes logarithmic, decades as grid lines; colours follow the reader's light or dark setting.
class LogPlot {
 public:
  explicit LogPlot(const Diagram& diagram) : diagram_(diagram) {
    double x_low = INFINITY, x_high = 0.0, y_low = INFINITY, y_high = 0.0;
    for (const Curve& curve : diagram.curves)
      for (const Point& p : curve.points) {
        x_low = std::min(x_low, p.x), x_high = std::max(x_high, p.x);
        y_low = std::min(y_low, p.y), y_high = std::max(y_high, p.y);
      }
    x_from_ = std::floor(2.0 * std::log10(x_low)) / 2.0, x_to_ = std::ceil(2.0 * std::log10(x_high)) / 2.0;
    y_from_ = std::floor(std::log10(y_low)), y_to_ = std::ceil(std::log10(y_high));
  }

  std::string svg() const {
    std::string out = fmt::format(
        R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0:g} {1:g}" width="{0:g}" height="{1:g}" role="img" )"
        R"(font-family="system-ui, 'DejaVu Sans', sans-serif" font-size="13"><title>{2}</title><style>)",
        width, height, diagram_.title);
    out += style();
    out += fmt::format("</style><rect class=\"card\" width=\"{:g}\" height=\"{:g}\" rx=\"10\"/>\n", width, height);
    out += fmt::format("<text x=\"{:g}\" y=\"28\" font-size=\"16\" class=\"strong\">{}</text>\n", left, diagram_.title);
    out += axes();
    for (std::size_t n = 0; n < diagram_.curves.size(); ++n) out += line(n);
    return out + legend() + "</svg>\n";
  }

 private:
  static constexpr double width = 980.0, height = 600.0, left = 86.0, right = 720.0, top = 48.0, bottom = 536.0;

  static std::string style() {
    const char* light[] = {"#8a5a2b", "#3b7fb5", "#2a9d7c", "#c0392b", "#7d3c98", "#6b7280", "#b8860b", "#111827"};
    const char* dark[] = {"#d9a066", "#6fb1d8", "#5fd3b0", "#ff7b6b", "#c79be0", "#a3acb9", "#f0c541", "#f3f4f6"};
    std::string css =
        ".card{fill:#ffffff}text{fill:#3d4653}.strong{fill:#1c2430}.grid{stroke:#e2e6ea}.frame{stroke:#9aa3ae}";
    std::string night =
        ".card{fill:#161b22}text{fill:#b9c2cd}.strong{fill:#f0f3f6}.grid{stroke:#2b323b}.frame{stroke:#6e7681}";
    for (int n = 0; n < 8; ++n) {
      css += fmt::format(".c{0}{{stroke:{1}}}.m{0}{{fill:{1}}}", n, light[n]);
      night += fmt::format(".c{0}{{stroke:{1}}}.m{0}{{fill:{1}}}", n, dark[n]);
    }
    return css + "@media (prefers-color-scheme: dark){" + night + "}";
  }
  double px(double x) const { return left + (right - left) * (std::log10(x) - x_from_) / (x_to_ - x_from_); }
  double py(double y) const { return bottom - (bottom - top) * (std::log10(y) - y_from_) / (y_to_ - y_from_); }

  std::string axes() const {
    std::string out;
    for (int e = static_cast<int>(std::ceil(x_from_)); e <= x_to_; ++e) {
      const double x = px(std::pow(10.0, e));
      out += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:g}V{:g}\"/>", x, top, bottom);
      out +=
          fmt::format("<text x=\"{:.1f}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>\n", x, bottom + 20.0, decade(e));
    }
    const int every = y_to_ - y_from_ > 9 ? 2 : 1;
    for (int e = static_cast<int>(y_from_); e <= y_to_; ++e) {
      const double y = py(std::pow(10.0, e));
      out += fmt::format("<path class=\"grid\" d=\"M{:g} {:.1f}H{:g}\"/>", left, y, right);
      if (e % every == 0)
        out += fmt::format("<text x=\"{:g}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", left - 8.0, y + 4.5,
                           decade(e));
    }
    out += fmt::format("<path class=\"frame\" fill=\"none\" d=\"M{:g} {:g}V{:g}H{:g}\"/>\n", left, top, bottom, right);
    out += fmt::format("<text x=\"{:g}\" y=\"{:g}\" text-anchor=\"middle\">{}</text>\n", 0.5 * (left + right),
                       bottom + 46.0, diagram_.x_label);
    out += fmt::format("<text transform=\"translate(22 {:g}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                       0.5 * (top + bottom), diagram_.y_label);
    return out;
  }
  static std::string decade(int exponent) {
    return fmt::format("10<tspan dy=\"-6\" font-size=\"10\">{}</tspan>",
                       exponent < 0 ? fmt::format("−{}", -exponent) : fmt::format("{}", exponent));
  }
  std::string line(std::size_t n) const {
    std::string path, marks;
    for (const Point& p : diagram_.curves[n].points) {
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", px(p.x), py(p.y));
      marks += mark(n, px(p.x), py(p.y));
    }
    return fmt::format("<path class=\"c{}\" fill=\"none\" stroke-width=\"2\"{} d=\"{}\"/>{}\n", n,
                       diagram_.curves[n].dashed ? " stroke-dasharray=\"6 4\"" : "", path, marks);
  }
  std::string mark(std::size_t n, double x, double y) const {
    if (diagram_.curves[n].dashed)
      return fmt::format("<rect class=\"m{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"7\" height=\"7\"/>", n, x - 3.5,
                         y - 3.5);
    return fmt::format("<circle class=\"m{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.8\"/>", n, x, y);
  }
  std::string legend() const {
    std::string out;
    double y = top + 14.0;
    const auto heading = [&](const char* text) {
      out += fmt::format("<text x=\"{:g}\" y=\"{:g}\" class=\"strong\">{}</text>\n", right + 22.0, y, text);
      y += 24.0;
    };
    for (bool dashed : {false, true}) {
      if (std::none_of(diagram_.curves.begin(), diagram_.curves.end(),
                       [&](const Curve& c) { return c.dashed == dashed; }))
        continue;
      heading(dashed ? "continuous equations" : "variational schemes");
      for (std::size_t n = 0; n < diagram_.curves.size(); ++n) {
        if (diagram_.curves[n].dashed != dashed) continue;
        out += fmt::format("<path class=\"c{}\" stroke-width=\"2\"{} d=\"M{:g} {:g}h30\"/>", n,
                           dashed ? " stroke-dasharray=\"6 4\"" : "", right + 22.0, y - 4.5);
        out += mark(n, right + 37.0, y - 4.5);
        out += fmt::format("<text x=\"{:g}\" y=\"{:g}\">{}</text>\n", right + 60.0, y,
                           diagram_.curves[n].name + (diagram_.curves[n].points.empty() ? ", off scale" : ""));
        y += 22.0;
      }
      y += 12.0;
    }
    return out;
  }

  const Diagram& diagram_;
  double x_from_, x_to_, y_from_, y_to_;  // decimal logarithms
};

bool write(const Diagram& diagram, const std::string& path) {
  std::ofstream stream(path);
  stream << LogPlot(diagram).svg();
  stream.flush();
  return stream.good();
}

}  // namespace

}  // namespace lamprey::bench

int main(int count, char** words) {
  using namespace lamprey::bench;
  if (count != 2) {
    fmt::print(stderr, "usage: lamprey_work_precision FOLDER: writes three diagrams there\n");
    return 2;
  }
  const std::string folder = words[1];
  const Tumble tumble;
  const auto truth = variational(tumble, lamprey::integrator::Scheme::order6)(1.0, 800.0, {});
  fmt::print("order6 at 1.25 ms and Runge–Kutta–Fehlberg at 1e-14 differ by {:.1e}\n",
             distance(truth, fehlberg(tumble)(1.0, 1e-14, {})));
  const bool written = write(work_precision(tumble, truth), folder + "/work_precision.svg") &&
                       write(energy_work(tumble), folder + "/energy_work.svg") &&
                       write(energy_balance(tumble), folder + "/energy_balance.svg");
  if (!written) fmt::print(stderr, "lamprey_work_precision: cannot write into {}\n", folder);
  return written ? 0 : 6;
}
