#pragma once
/// The error models that come with the program: configs/error_models as it was when the program was built.
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "config/input_table.h"
#include "error_model/model.h"

namespace surveymc::config {

/// The files; `path` is a file's name without folder and ending.
const std::vector<InputText>& shipped_error_model_files();

/// A model by its place in a file. Nothing of it is parsed but these three names.
struct ShippedModel {
  std::string name;       ///< "MWD+IFR1"
  std::string catalogue;  ///< the file: "owsg_a_rev5.1"
  std::string extends;    ///< name of the model that it changes; empty if it stands alone
  std::string_view text;  ///< of the model: its [[model]] table, or the whole file that has only one
};
/// All of them, in the order of the catalogues.
const std::vector<ShippedModel>& shipped_models();
/// By name, or by catalogue and name: "owsg_a_rev5.1/MWD+IFR1". Null if there is none.
const ShippedModel* find_shipped_model(const std::string& name);
/// The model's text as a document, with the path "<shipped>/NAME.toml"; what it extends is a document of its own.
InputText shipped_document(const ShippedModel& model);
/// What a user may have meant by a name that is no model's, for the end of a message.
std::string shipped_model_suggestion(const std::string& name);

/// Names of models by patterns in which * stands for any text; those that one of `match` fits and none of `without`, in
/// the order of the catalogues.
std::vector<std::string> matching_shipped_models(const std::vector<std::string>& match,
                                                 const std::vector<std::string>& without);

/// Functions of models by their names.
using FunctionTable = std::map<std::string, std::shared_ptr<const error_model::Function>>;
/// The weighting functions that every model may name: functions.toml.
const FunctionTable& shipped_functions();

}  // namespace surveymc::config
