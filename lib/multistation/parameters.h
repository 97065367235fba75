#pragma once
/// The one table of constant errors that multi-station analysis can estimate, and the sets of them.
///
///   g_read = (1 + diag(as) + Na) g + ab,   b_read = (1 + [r]x + N + diag(ms)) b + mb
/// g, b: specific gravity and field at the station, tool frame; [r]x the cross matrix of r: the rotation of the
/// magnetometers against the accelerometers; N, Na symmetric with zero diagonals: axes that are not orthogonal.
/// Estimator, first-order prediction, observability and tables read this table and nothing else.
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace surveymc::multistation {

/// Index of the first of the three parameters of each kind. The first twelve are survey::SensorTerm.
enum Kind {
  kAccelerometerBias = 0,
  kAccelerometerScale = 3,
  kMagnetometerBias = 6,
  kMagnetometerScale = 9,
  kRotation = 12,           ///< of the magnetometers, about x, y, z
  kMagnetometerSkew = 15,   ///< xy, xz, yz
  kAccelerometerSkew = 18,  ///< xy, xz, yz
};
inline constexpr int kParameters = 21, kKinds = 7;

enum class Instrument { accelerometer, magnetometer, both };

struct Parameter {
  const char* name;
  const char* unit;
  double prior_sd;  ///< default prior about 0, one standard deviation
  Instrument instrument;
  const char* meaning;
  bool of_accelerometer() const { return instrument == Instrument::accelerometer; }
};

/// One value a parameter of the table: errors, or standard deviations.
template <class T>
using PerParameter = std::array<T, kParameters>;

/// Priors: biases and scales as in the corrected tool codes; a milliradian for directions of axes, as mwdstdcore takes.
inline constexpr PerParameter<Parameter> kTable{{
    {"abx", "m/s2", 0.004, Instrument::accelerometer, "bias of accelerometer x"},
    {"aby", "m/s2", 0.004, Instrument::accelerometer, "bias of accelerometer y"},
    {"abz", "m/s2", 0.004, Instrument::accelerometer, "bias of accelerometer z"},
    {"asx", "1", 0.0005, Instrument::accelerometer, "scale error of accelerometer x"},
    {"asy", "1", 0.0005, Instrument::accelerometer, "scale error of accelerometer y"},
    {"asz", "1", 0.0005, Instrument::accelerometer, "scale error of accelerometer z"},
    {"mbx", "nT", 70, Instrument::magnetometer, "bias of magnetometer x"},
    {"mby", "nT", 70, Instrument::magnetometer, "bias of magnetometer y"},
    {"mbz", "nT", 231, Instrument::magnetometer, "bias of magnetometer z, with the drill string's field"},
    {"msx", "1", 0.0016, Instrument::magnetometer, "scale error of magnetometer x"},
    {"msy", "1", 0.0016, Instrument::magnetometer, "scale error of magnetometer y"},
    {"msz", "1", 0.0016, Instrument::magnetometer, "scale error of magnetometer z"},
    {"rx", "rad", 0.001, Instrument::both, "rotation of the magnetometers against the accelerometers, about x"},
    {"ry", "rad", 0.001, Instrument::both, "rotation of the magnetometers against the accelerometers, about y"},
    {"rz", "rad", 0.001, Instrument::both, "rotation of the magnetometers against the accelerometers, about z"},
    {"nxy", "rad", 0.001, Instrument::magnetometer, "magnetometers x and y not orthogonal"},
    {"nxz", "rad", 0.001, Instrument::magnetometer, "magnetometers x and z not orthogonal"},
    {"nyz", "rad", 0.001, Instrument::magnetometer, "magnetometers y and z not orthogonal"},
    {"axy", "rad", 0.001, Instrument::accelerometer, "accelerometers x and y not orthogonal"},
    {"axz", "rad", 0.001, Instrument::accelerometer, "accelerometers x and z not orthogonal"},
    {"ayz", "rad", 0.001, Instrument::accelerometer, "accelerometers y and z not orthogonal"},
}};
constexpr const Parameter& parameter(int index) { return kTable[static_cast<std::size_t>(index)]; }

/// Default priors of the table.
PerParameter<double> default_priors();

/// Index of a name in the table, -1 if there is none.
int find_parameter(std::string_view name);

/// Names of the sets: "6" mb, ms; "9" 6 and r; "12" ab, as, mb, ms; "15" 12 and r; "18" 15 and N; "21" all.
const std::vector<std::string>& set_names();

/// Which parameters are estimated: some of the table, in its order.
class ParameterSet {
 public:
  /// Of a name of set_names(). Throws InputError ("must be one of ...").
  static ParameterSet named(std::string_view name);
  /// Of parameters by name, in any order. Throws InputError: none, an unknown one, one twice.
  static ParameterSet of(const std::vector<std::string>& parameters);

  int size() const { return static_cast<int>(indices_.size()); }
  /// Place i of the set in the table.
  int index(int i) const { return indices_[static_cast<std::size_t>(i)]; }
  const Parameter& operator[](int i) const { return parameter(index(i)); }
  bool contains(int table_index) const { return contained_[static_cast<std::size_t>(table_index)]; }
  /// True if one of the three parameters of a kind is in the set.
  bool contains_kind(int kind) const { return contains(kind) || contains(kind + 1) || contains(kind + 2); }
  /// True if readings of the accelerometers are corrected.
  bool corrects_accelerometers() const {
    return contains_kind(kAccelerometerBias) || contains_kind(kAccelerometerScale) || contains_kind(kAccelerometerSkew);
  }
  std::vector<std::string_view> names() const;
  /// The name of the set, or of its parameters: "12"; "mbx, mby".
  std::string name() const;

 private:
  std::vector<int> indices_;
  PerParameter<bool> contained_{};
};

}  // namespace surveymc::multistation
