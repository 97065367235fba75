#pragma once
/// Notes and warnings on the survey or the readings that a study was given; `run` and `check` print them.
#include "config/config.h"
#include "config/readings_csv.h"
#include "config/survey_csv.h"
#include "survey/reference_field.h"
#include "survey/six_axis.h"
#include "survey/survey.h"

namespace surveymc::scenario {

/// "true", "magnetic" or "grid".
const char* north_name(config::AzimuthReference north);

/// Notes stations, depths, largest inclination and dogleg, and where azimuths are from, and warns of what is unusual
/// (config/survey_checks.h). Throws InputError where it is so unusual that the user has to say that it is meant, with
/// `survey.unusual = "allow"`, which makes a warning of it. `unusual`: that key, of a survey that is not the only one.
void remark_on_survey(config::ConfigReader& config, const config::InputTable& table, const survey::Survey& survey,
                      const config::SurveyConventions& conventions, const std::string& unusual = "survey.unusual");

/// Notes stations, depths, and the mean gravity, total field and dip of the readings; warns where their dip has the
/// other sign than the reference.
void remark_on_readings(config::ConfigReader& config, const survey::SixAxisReadings& readings,
                        const survey::ReferenceField& field);

}  // namespace surveymc::scenario
