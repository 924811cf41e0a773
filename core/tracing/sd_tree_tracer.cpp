#include "core/tracing/path_tracer.h"
#include "core/tracing/sd_tree_guide.h"

namespace lodestar {

template class PathTracer<SdTreeGuide<false>>;
template class PathTracer<SdTreeGuide<true>>;

}  // namespace lodestar
