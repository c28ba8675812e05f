#include "result/trajectory_file.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <optional>

#include "document/io_error.hpp"
#include "result/result_shapes.hpp"

namespace lamprey::result {

namespace {

constexpr const char* unwritable = "cannot be written as HDF5";
constexpr const char* unreadable = "cannot be read as HDF5; write it anew with solve or simulate, or delete it";

// An HDF5 identifier closed by its own kind's function.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& path, const char* failure = unwritable)
      : id_(id), close_(close) {
    if (id < 0) throw document::IoError(path, failure);
  }
  ~Handle() { close_(id_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// One thread at a time is in the library, which keeps its open files in one list. It prints its own error stack unless told not to; we
// report through exceptions.
class Library {
 public:
  Library() : lock_(mutex_) {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Library() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

 private:
  static inline std::mutex mutex_;
  std::scoped_lock<std::mutex> lock_;
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

void require(herr_t status, const std::string& path, const char* failure = unwritable) {
  if (status < 0) throw document::IoError(path, failure);
}

void write_unit(hid_t dataset, const std::string& unit, const std::string& path) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, path);
  require(H5Tset_size(type, unit.size()), path);
  require(H5Tset_strpad(type, H5T_STR_NULLPAD), path);
  require(H5Tset_cset(type, H5T_CSET_UTF8), path);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, path);
  const Handle attribute(H5Acreate2(dataset, "unit", type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, path);
  require(H5Awrite(attribute, type, unit.data()), path);
}

// Names in the order of an axis of the arrays, as the file's own attribute.
void write_names(hid_t file, const char* attribute, const std::vector<std::string>& names, const std::string& path) {
  std::size_t longest = 1;
  for (const std::string& name : names) longest = std::max(longest, name.size());
  std::string padded;
  for (const std::string& name : names) padded += name + std::string(longest - name.size(), '\0');
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, path);
  require(H5Tset_size(type, longest), path);
  require(H5Tset_strpad(type, H5T_STR_NULLPAD), path);
  require(H5Tset_cset(type, H5T_CSET_UTF8), path);
  const hsize_t count = names.size();
  const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose, path);
  const Handle written(H5Acreate2(file, attribute, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, path);
  if (!names.empty()) require(H5Awrite(written, type, padded.data()), path);
}

template <class Named>
std::vector<std::string> names_of(const std::vector<Named>& all) {
  std::vector<std::string> names;
  for (const Named& one : all) names.push_back(one.name);
  return names;
}

void write_groups(hid_t file, const std::vector<ShapedArray>& arrays, const std::string& path) {
  std::vector<const char*> groups = {"velocity", "momentum", "momentum/linear", "momentum/angular"};
  for (const ShapedArray& array : arrays)
    if (array.path() == "feedback/gain") groups.push_back("feedback");
  for (const char* group : groups) {
    const Handle properties(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, path);
    require(H5Pset_obj_track_times(properties, false), path);
    const Handle created(H5Gcreate2(file, group, H5P_DEFAULT, properties, H5P_DEFAULT), H5Gclose, path);
  }
}

void write_array(hid_t file, const ShapedArray& array, const std::string& path) {
  const std::vector<hsize_t> shape(array.shape.begin(), array.shape.end());
  const Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose, path);
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, path);
  require(H5Pset_obj_track_times(properties, false), path);
  const Handle dataset(
      H5Dcreate2(file, array.path().c_str(), H5T_IEEE_F64LE, space, H5P_DEFAULT, properties, H5P_DEFAULT), H5Dclose,
      path);
  if (!array.values.empty())
    require(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()), path);
  write_unit(dataset, array.unit, path);
}

// Built in memory: a full disk then meets our own writing, not the library, which cannot close a file that it failed to write.
std::string file_image(const Results& results) {
  const std::vector<ShapedArray> arrays = shaped_arrays(results);
  const Library library;
  const std::string name = "trajectory.h5";
  constexpr std::size_t growth = std::size_t{1} << 20;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, name);
  require(H5Pset_fapl_core(access, growth, false), name);
  const Handle properties(H5Pcreate(H5P_FILE_CREATE), H5Pclose, name);
  require(H5Pset_obj_track_times(properties, false), name);
  const Handle file(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, properties, access), H5Fclose, name);
  write_names(file, "bodies", names_of(results.problem.bodies), name);
  write_names(file, "joints", names_of(results.problem.joints), name);
  write_groups(file, arrays, name);
  for (const ShapedArray& array : arrays) write_array(file, array, name);
  require(H5Fflush(file, H5F_SCOPE_GLOBAL), name);
  const ssize_t size = H5Fget_file_image(file, nullptr, 0);
  if (size < 0) throw document::IoError(name, unwritable);
  std::string image(static_cast<std::size_t>(size), '\0');
  if (H5Fget_file_image(file, image.data(), image.size()) != size) throw document::IoError(name, unwritable);
  return image;
}

std::string shape_in_words(const std::vector<std::size_t>& shape) {
  std::string words;
  for (const std::size_t length : shape) words += fmt::format("[{}]", length);
  return words;
}

// Indices of an entry in row-major order.
std::string place_in_words(std::size_t entry, const std::vector<std::size_t>& shape) {
  std::vector<std::size_t> place(shape.size());
  for (std::size_t axis = shape.size(); axis-- > 0;) {
    place[axis] = entry % shape[axis];
    entry /= shape[axis];
  }
  return shape_in_words(place);
}

// Whether each group on the way to an array and the array itself are there.
bool has_array(hid_t file, const std::string& path) {
  for (std::size_t end = path.find('/');; end = path.find('/', end + 1)) {
    if (H5Lexists(file, path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

// Texts that lie one after the other, each as long as the longest.
std::vector<std::string> padded_texts(hid_t attribute, hid_t type, std::size_t count, const std::string& path) {
  const std::size_t longest = H5Tget_size(type);
  std::string padded(longest * count, '\0');
  if (!padded.empty()) require(H5Aread(attribute, type, padded.data()), path, unreadable);
  std::vector<std::string> texts;
  for (std::size_t n = 0; n < count; ++n) texts.emplace_back(padded.substr(n * longest, longest).c_str());
  return texts;
}

// Texts each of a length of its own, which the library allocates: h5py's, where it is not told otherwise.
std::vector<std::string> separate_texts(hid_t attribute, hid_t type, hid_t space, std::size_t count,
                                        const std::string& path) {
  std::vector<char*> read(count, nullptr);
  if (count > 0) require(H5Aread(attribute, type, read.data()), path, unreadable);
  std::vector<std::string> texts;
  for (const char* text : read) texts.emplace_back(text != nullptr ? text : "");
  if (count > 0) H5Dvlen_reclaim(type, space, H5P_DEFAULT, read.data());
  return texts;
}

// Texts of an attribute; nothing where it is not there, or is of another kind.
std::optional<std::vector<std::string>> texts_of(hid_t object, const char* name, const std::string& path) {
  if (H5Aexists(object, name) <= 0) return std::nullopt;
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose, path, unreadable);
  const Handle type(H5Aget_type(attribute), H5Tclose, path, unreadable);
  const Handle space(H5Aget_space(attribute), H5Sclose, path, unreadable);
  if (H5Tget_class(type) != H5T_STRING) return std::nullopt;
  const hssize_t points = H5Sget_simple_extent_npoints(space);
  require(points < 0 ? -1 : 0, path, unreadable);
  const auto count = static_cast<std::size_t>(points);
  return H5Tis_variable_str(type) > 0 ? separate_texts(attribute, type, space, count, path)
                                      : padded_texts(attribute, type, count, path);
}

// What an attribute says other than it should.
std::string text_difference(hid_t object, const char* name, const std::vector<std::string>& is, const std::string& of,
                            const std::string& path) {
  const auto told = texts_of(object, name, path);
  if (!told) return fmt::format("{}{} is missing", of, name);
  if (*told == is) return "";
  return fmt::format("{}{} is \"{}\", not \"{}\"", of, name, fmt::join(*told, "\", \""), fmt::join(is, "\", \""));
}

std::string array_difference(hid_t file, const ShapedArray& array, const std::string& path) {
  if (!has_array(file, array.path())) return fmt::format("{} is missing", array.path());
  const Handle dataset(H5Dopen2(file, array.path().c_str(), H5P_DEFAULT), H5Dclose, path, unreadable);
  const Handle space(H5Dget_space(dataset), H5Sclose, path, unreadable);
  std::vector<hsize_t> lengths(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
  require(H5Sget_simple_extent_dims(space, lengths.data(), nullptr), path, unreadable);
  const std::vector<std::size_t> shape(lengths.begin(), lengths.end());
  if (shape != array.shape)
    return fmt::format("{} is {}, not {}", array.path(), shape_in_words(shape), shape_in_words(array.shape));
  std::vector<double> values(array.values.size());
  if (const std::string unit = text_difference(dataset, "unit", {array.unit}, array.path() + ": ", path); !unit.empty())
    return unit;
  if (!values.empty())
    require(H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), path, unreadable);
  for (std::size_t entry = 0; entry < values.size(); ++entry)
    if (values[entry] != array.values[entry])  // NaN, too, is another number
      return fmt::format("{}{} is {}, not {}", array.path(), place_in_words(entry, shape), values[entry],
                         array.values[entry]);
  return "";
}

}  // namespace

std::string trajectory_difference(const std::string& folder, const Results& results) {
  const std::string path = (std::filesystem::path(folder) / "trajectory.h5").string();
  if (!std::filesystem::exists(path)) return "";
  const Library library;
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, path, unreadable);
  const std::string bodies = text_difference(file, "bodies", names_of(results.problem.bodies), "", path);
  if (!bodies.empty()) return bodies;
  const std::string joints = text_difference(file, "joints", names_of(results.problem.joints), "", path);
  if (!joints.empty()) return joints;
  for (const ShapedArray& array : shaped_arrays(results)) {
    const std::string difference = array_difference(file, array, path);
    if (!difference.empty()) return difference;
  }
  return "";
}

document::PendingFile trajectory_file(const Results& results) {
  return document::finished_file("trajectory.h5", file_image(results));
}

void write_trajectory(const std::string& folder, const Results& results) {
  document::write_files(folder, {trajectory_file(results)});
}

}  // namespace lamprey::result
