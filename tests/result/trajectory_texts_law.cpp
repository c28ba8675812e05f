// Names and units in trajectory.h5, whichever way a program has stored their texts.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <array>
#include <cstring>

#include "file/samples.hpp"
#include "result/trajectory_file.hpp"

namespace lamprey {
namespace {

// Stores the texts anew, as h5py does where it is not told otherwise.
void store_with_lengths_of_their_own(const std::string& path, const char* object, const char* name,
                                     std::vector<const char*> texts, bool scalar) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t of = H5Oopen(file, object, H5P_DEFAULT), type = H5Tcopy(H5T_C_S1);
  const hsize_t count = texts.size();
  const hid_t space = scalar ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  H5Adelete(of, name);
  const hid_t attribute = H5Acreate2(of, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  EXPECT_GE(H5Awrite(attribute, type, texts.data()), 0);
  H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
  H5Oclose(of);
  H5Fclose(file);
}

TEST(TrajectoryTexts, with_lengths_of_their_own_are_compared_too) {
  const tests::TemporaryFolder folder;
  const result::Results results = tests::sample_results(6);
  const std::string path = folder / "trajectory.h5";
  const auto difference = [&] { return result::trajectory_difference(folder.path(), results); };
  result::write_trajectory(folder.path(), results);
  store_with_lengths_of_their_own(path, "/", "bodies", {"middle", "front", "back"}, false);
  store_with_lengths_of_their_own(path, "time", "unit", {"s"}, true);
  store_with_lengths_of_their_own(path, "momentum/angular/total", "unit", {"kg m²/s"}, true);
  EXPECT_EQ(difference(), "");
  store_with_lengths_of_their_own(path, "time", "unit", {"hours"}, true);
  EXPECT_EQ(difference(), "time: unit is \"hours\", not \"s\"");
  store_with_lengths_of_their_own(path, "/", "bodies", {"middle", "front", "tail of the eel"}, false);
  EXPECT_EQ(difference(), "bodies is \"middle\", \"front\", \"tail of the eel\", not \"middle\", \"front\", \"back\"");
}

TEST(TrajectoryTexts, that_are_missing_are_a_difference) {
  const tests::TemporaryFolder folder;
  const result::Results results = tests::sample_results(6);
  const std::string path = folder / "trajectory.h5";
  for (const auto& [object, name, words] :
       {std::array{"/", "bodies", "bodies is missing"}, std::array{"/", "joints", "joints is missing"},
        std::array{"momentum/angular/total", "unit", "momentum/angular/total: unit is missing"}}) {
    result::write_trajectory(folder.path(), results);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    EXPECT_GE(H5Adelete_by_name(file, object, name, H5P_DEFAULT), 0);
    H5Fclose(file);
    EXPECT_EQ(result::trajectory_difference(folder.path(), results), words);
  }
}

}  // namespace
}  // namespace lamprey
