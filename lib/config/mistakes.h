#pragma once
/// All mistakes of a point at once: ConfigReader::mistakes_of(). Internal to the module.
#include <set>
#include <string>
#include <vector>

#include "config/config_point.h"

namespace surveymc::config {

/// What depends on a value that a stand-in has taken the place of.
enum class Decides {
  nothing,    // of a number: what it is compared with, by study code
  its_table,  // of a text or a file: what is wrong with other keys of its top-level table
  presence    // of a word or a switch: these, and which keys must be there or may not
};

struct ConfigReader::Mistakes {
  /// A getter has thrown `message`, and goes on with a stand-in. `is_missing`: the key is not there.
  void add(const std::string& full_key, const std::string& message, bool is_missing, Decides decides);
  /// finish() of a reader has found these.
  void add_unknown(const std::vector<Point::UnknownKey>& unknown);
  /// What has ended the reading, unless a stand-in may be to blame.
  void add_last(const std::string& message);

  /// Every key was asked for that the config's branches ask for.
  bool is_whole() const { return is_whole_; }
  /// All of them; `sure`: unknown keys that no branch of the study asks for.
  std::vector<std::string> messages(const std::vector<Point::UnknownKey>& sure) const;

 private:
  void tell(const std::string& message);

  std::vector<std::string> told_;
  std::string last_;  // what has ended the reading
  std::vector<Point::UnknownKey> unknown_;
  bool has_stand_in_ = false, is_presence_decided_ = false, is_whole_ = false;
  std::set<std::string> tables_;  // of which a stand-in decides
};

/// An InputTable that any survey may be: more of it than of any well, so that no depth lies outside.
const InputTable& survey_stand_in();

template <class Value, class Get>
Value ConfigReader::or_stand_in(const std::string& key, Decides decides, const Value& stand_in, const Get& get) const {
  if (!point_->mistakes) return get();
  try {
    return get();
  } catch (const InputError& e) {
    point_->mistakes->add(full_key(key), e.what(), !look_up(key), decides);
    return stand_in;
  }
}

}  // namespace surveymc::config
