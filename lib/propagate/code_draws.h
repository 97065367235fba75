#pragma once
/// What the tool code of an uncorrected magnetic survey says of the tool and of its reference, as errors of six axes
/// and of the field that can be drawn: the inputs of a correction, whose result another code claims.
#include <string>
#include <vector>

#include "error_model/model.h"
#include "survey/reference_field.h"
#include "survey/sensor_terms.h"

namespace surveymc::propagate {

/// Sizes of the errors, one standard deviation each. The toolface-independent terms of a code are the mean over one
/// constant toolface of errors of these sizes (toolface_independent.h).
struct CodeDraws {
  survey::SensorTermArray sensors{};  ///< once a run; without the interference
  double interference = 0;            ///< nT, of the drill string (AMIL): once a run, added to the bias of z
  /// Of the reference: total field (nT), dip (rad); declination as the sum of an angle (rad) and of an east field
  /// (rad nT) over the horizontal field.
  struct Reference {
    double total = 0, dip = 0, declination = 0, east = 0;
    double declination_in(const survey::ReferenceField& field) const;  ///< rad
  };
  Reference run, station;  ///< once a run; anew at every station

  /// One standard deviation of the bias of z, nT.
  double axial_bias() const;
  /// All sizes times `factor`.
  CodeDraws scaled(double factor) const;
};

/// A term of a code and what becomes of it.
struct CodeTerm {
  std::string code, model, drawn_as;  ///< drawn_as: "magnetometer bias x, y"
  char mode = 'S';
  double magnitude = 0;
  std::string unit;
  bool carried = false;  ///< not drawn: no correction of magnetometers changes it
};

struct MappedCode {
  CodeDraws draws;
  std::vector<CodeTerm> terms;  ///< of the code, in its order, then those of the reference
};

/// The errors of `base`. Total field and dip, of which a code without axial correction says nothing, are read from the
/// terms MFI and MDI of `reference_of`, its twin with axial correction; null: they are 0. Throws InputError by the
/// term's name where a term cannot be drawn: a function of another kind of tool or of a corrected one, an error of the
/// sensors drawn anew at every station, terms of one axis pair whose magnitudes differ.
MappedCode map_code(const error_model::Model& base, const error_model::Model* reference_of);

/// True of a term that a correction of magnetometers leaves as it is: depth, sag, misalignment, course.
bool is_carried(const error_model::Term& term);

/// The model with the terms of which `is_carried` is as asked. Throws InputError by the term's name if the model has a
/// term of another kind of tool.
error_model::Model carried_part(const error_model::Model& model, bool carried);

/// Of the names `all`, that which has the parts of `base` between its "+" signs and "AX": "MWD+IFR2+AX+SAG" for
/// "MWD+IFR2+SAG". "" if there is none.
std::string axial_twin(const std::string& base, const std::vector<std::string>& all);

}  // namespace surveymc::propagate
