#include "core/tracing/mixed_guide.h"
#include "core/tracing/path_tracer.h"

namespace lodestar {

template class PathTracer<MixedGuide>;

}  // namespace lodestar
