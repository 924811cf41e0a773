// What a slow reader is to get next. Not thread-safe.
#pragma once

#include <functional>
#include <optional>
#include <utility>

namespace lodestar {

// The newest of what was offered since something was taken. One for which `last` holds is not replaced: what was made
// before it may be offered after it, and nothing follows that would end the reader's wait.
template <class Message>
class Newest {
 public:
  explicit Newest(std::function<bool(const Message&)> last) : last_(std::move(last)) {}
  void Offer(Message message) {
    if (!waiting_ || !last_(*waiting_)) waiting_ = std::move(message);
  }
  std::optional<Message> Take() { return std::exchange(waiting_, std::nullopt); }

 private:
  const std::function<bool(const Message&)> last_;
  std::optional<Message> waiting_;
};

}  // namespace lodestar
