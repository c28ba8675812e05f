// How a shape's coordinates turn the bodies, of four steps at once, where joints lead some of them (chapter 9, equations 9.21
// to 9.25). A coordinate's axis w is seen from the root; it turns a body i by Q_iᵀ w in the body's own frame.
#pragma once

#include <vector>

#include "mechanics/four_bodies.hpp"

namespace lamprey::shape {

class LedTurns {
 public:
  using Four = mechanics::Four;
  using Four3 = mechanics::Four3;
  using Four33 = mechanics::Four33;

  explicit LedTurns(const model::System& system);

  /// Whether a joint leads its child at all; else coordinates are the bodies' own turns.
  bool any() const { return any_; }
  /// Number of coordinates.
  int size() const { return static_cast<int>(column_.size()); }

  /// A shape: rotations seen from the root, [bodies].
  void take(const std::vector<Four33>& shape);

  /// What moments on the bodies do along the coordinates. `moment`: [bodies − 1], own frames, bodies but the root.
  void gather(const Four3* moment, Four* along) const;

  /// The bodies' turns along the coordinates, [bodies − 1]; how axes and turns change with them is kept.
  void spread(const Four* along, Four3* turn);

  /// Columns that belong to bodies become columns that belong to coordinates: [rows][3 (bodies − 1)] and [rows][size], column
  /// after column.
  void project_columns(int rows, const Four* by_bodies, Four* by_coordinates) const;
  /// Likewise rows, [3 (bodies − 1)][columns] and [size][columns], each column with a stride; by how turns change, where `changes`.
  void project_rows(int columns, const Four* by_bodies, int stride, Four* by_coordinates, int to_stride,
                    bool changes = false) const;

  /// A coordinate's turn changes along those after it on the way down the tree. Adds what moments on the bodies make of that,
  /// row: the coordinate whose turn changes, column: along which. `form`: [size] squared within a larger one.
  void add_bend(const Four3* moment, Four* form, int stride) const;
  /// Its symmetric part.
  void add_symmetric_bend(const Four3* moment, Four* form, int stride) const;
  /// And the change of that along the turns of `spread`, moments changing too.
  void add_bend_change(const Four3* moment, const Four3* moment_change, Four* form, int stride) const;
  /// Second derivative, along coordinates, of what a moment on one body does along those of `spread`.
  void add_twice_bent(int body, const Four3& moment, const Four* along, Four* form, int stride) const;

  /// Bodies that turn on their own, and the place of the first of their three coordinates.
  struct FreeBody {
    int body, place;
  };
  const std::vector<FreeBody>& free_bodies() const { return free_body_; }

 private:
  // A body that a coordinate turns.
  struct Turned {
    int body;
    Four3 turn, change;  // Qᵀ w, and how it changes
  };
  struct Column {
    int body;     // the child of its joint
    int freedom;  // which of the body's
    bool led;
    std::vector<Turned> turned;
    std::vector<int> before;  // of a led one: coordinates before it on the way down the tree that turn what it turns
    Four3 axis, axis_change;  // w
  };
  Four3 pull(const Column& column, const Four3* moment) const;

  const model::System& system_;
  bool any_ = false;
  std::vector<Column> column_;
  std::vector<FreeBody> free_body_;
  std::vector<Four33> shape_;     // [bodies]
  std::vector<Four3> body_turn_;  // [bodies] seen from the root, of the latest spread
};

}  // namespace lamprey::shape
