#include "core/tracing/focal_guide.h"
#include "core/tracing/path_tracer.h"

namespace lodestar {

template class PathTracer<FocalGuide>;

}  // namespace lodestar
