#include "core/tracing/grid_guide.h"
#include "core/tracing/path_tracer.h"

namespace lodestar {

template class PathTracer<GridGuide>;

}  // namespace lodestar
