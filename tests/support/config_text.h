#pragma once
/// What is read of a config that a test writes down.
#include <string>
#include <utility>
#include <vector>

#include "config/config.h"

namespace surveymc::test {

/// read(reader) of a config of one point with the text of an experiment, called t.toml in messages. Every key must be
/// read. `remarks`: what is told meanwhile.
template <class Read>
auto read_config(const std::string& body, const Read& read, std::vector<config::Remark>* remarks = nullptr,
                 std::vector<config::InputTable> tables = {}, std::vector<config::InputText> texts = {}) {
  config::Config config =
      config::Config::from_text("experiment = 'e'\n" + body, "t.toml", std::move(tables), std::move(texts));
  config::ConfigReader reader = config.reader(0);
  auto value = read(reader);
  reader.finish();
  if (remarks) *remarks = config.remarks();
  return value;
}

}  // namespace surveymc::test
