#pragma once
#include <string>

namespace surveymc::cli {

struct ModelsArguments {
  std::string name;  ///< of a model; empty: list them
  std::string file;  ///< a file of models; empty: those that come with the program
};

/// `surveymc models`: a line per error model (name, terms, range of inclinations, title), or one model as TOML with its
/// functions, ready to edit. Throws InputError for a name that is none.
std::string models_text(const ModelsArguments& arguments);

}  // namespace surveymc::cli
