#include "compare/answer.h"
#include "events/event_study.h"
#include "store/result_file.h"

namespace surveymc::studies::rare_event {

using compare::Rows;

void answer(compare::Answer& answer, const store::Result& result) { events::say_probabilities(answer, result); }

}  // namespace surveymc::studies::rare_event
