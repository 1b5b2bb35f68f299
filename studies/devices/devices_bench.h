// `kappamu-studies devices`: rows of its record.
#pragma once

#include "studies/devices/device_tasks.h"

namespace kappamu::studies {

/// The task on each place that can take it. Answers are compared with the last processor's;
/// `times_processor` is null and "refused" says why where they differ by more than is allowed.
std::vector<Json> rows_of_task(const DeviceTask& task, const std::vector<Place>& places);

}  // namespace kappamu::studies
