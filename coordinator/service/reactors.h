// The shapes of RPC as reactors of gRPC's callback API: no shape pins a thread while it waits. A reactor deletes itself
// when gRPC is done with it.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>

#include "coordinator/service/newest.h"
#include "coordinator/service/work_pool.h"
#include "rpc/convert.h"
#include "rpc/status.h"

namespace lodestar {

// OK, or what is wrong with the caller's protocol version.
grpc::Status CheckProtocol(const grpc::CallbackServerContext* context);
grpc::Status QueueFull();

// A call that is answered by a function on the pool.
template <class Request, class Reply>
grpc::ServerUnaryReactor* Answer(grpc::CallbackServerContext* context, WorkPool& pool, const Request* request,
                                 Reply* reply, std::function<void(const Request&, Reply*)> handler) {
  auto* reactor = context->DefaultReactor();
  if (const auto status = CheckProtocol(context); !status.ok()) {
    reactor->Finish(status);
  } else if (!pool.Post([=, handler = std::move(handler)] {
               reactor->Finish(Guarded([&] {
                 RefuseUnknownFields(*request);
                 handler(*request, reply);
               }));
             })) {
    reactor->Finish(QueueFull());
  }
  return reactor;
}

// A call whose answer may come much later, from elsewhere.
template <class Reply>
class ParkedCall final : public grpc::ServerUnaryReactor {
 public:
  // `park` gets the function to answer with, and returns the number to withdraw (0: answered already).
  ParkedCall(Reply* reply, std::function<void(uint64_t)> withdraw)
      : shared_(std::make_shared<Shared>()), withdraw_(std::move(withdraw)) {
    shared_->reactor = this;
    shared_->reply = reply;
  }
  void Park(const std::function<uint64_t(std::function<bool(const Reply&)>)>& park) {
    const auto shared = shared_;  // the call may be over, and this object gone, before `park` returns
    const auto withdraw = withdraw_;
    uint64_t call = 0;
    const auto status = Guarded(
        [&] { call = park([shared](const Reply& reply) { return shared->Finish(grpc::Status::OK, &reply); }); });
    if (!status.ok()) shared->Finish(status, nullptr);
    bool cancelled;
    {
      std::lock_guard lock(shared->mutex);
      shared->call = call;
      cancelled = shared->cancelled;
    }
    if (cancelled && call != 0) withdraw(call);
  }
  void OnCancel() override {
    uint64_t call;
    {
      std::lock_guard lock(shared_->mutex);
      shared_->cancelled = true;
      call = shared_->call;
    }
    if (call != 0) withdraw_(call);
    shared_->Finish(grpc::Status::CANCELLED, nullptr);
  }
  void OnDone() override { delete this; }

 private:
  struct Shared {
    std::mutex mutex;
    ParkedCall* reactor = nullptr;  // null: finished
    Reply* reply = nullptr;
    uint64_t call = 0;
    bool cancelled = false;
    bool Finish(const grpc::Status& status, const Reply* answer) {
      ParkedCall* mine = nullptr;
      {
        std::lock_guard lock(mutex);
        if (!reactor) return false;
        if (answer && cancelled) return false;
        if (answer) *reply = *answer;
        mine = std::exchange(reactor, nullptr);
      }
      mine->grpc::ServerUnaryReactor::Finish(status);
      return true;
    }
  };
  const std::shared_ptr<Shared> shared_;
  const std::function<void(uint64_t)> withdraw_;
};

// An answer in parts: `open` runs on the pool, the parts are made one at a time as they are taken.
template <class Chunk>
class ChunkWriter final : public grpc::ServerWriteReactor<Chunk> {
 public:
  using Next = std::function<bool(Chunk*)>;
  static ChunkWriter* Start(grpc::CallbackServerContext* context, WorkPool& pool,
                            const google::protobuf::Message* request, std::function<Next()> open) {
    auto* writer = new ChunkWriter;
    if (const auto status = CheckProtocol(context); !status.ok()) {
      writer->Finish(status);
    } else if (!pool.Post([writer, request, open = std::move(open)] {
                 const auto status = Guarded([&] {
                   RefuseUnknownFields(*request);
                   writer->next_ = open();
                 });
                 status.ok() ? writer->WriteNext() : writer->Finish(status);
               })) {
      writer->Finish(QueueFull());
    }
    return writer;
  }
  void OnWriteDone(bool ok) override { ok ? WriteNext() : this->Finish(grpc::Status::CANCELLED); }
  void OnDone() override { delete this; }

 private:
  void WriteNext() {
    bool more = false;
    const auto status = Guarded([&] {
      chunk_.Clear();
      more = next_(&chunk_);
    });
    status.ok() && more ? this->StartWrite(&chunk_) : this->Finish(status);
  }
  Next next_;
  Chunk chunk_;
};

// A question in parts: Handler has Add(chunk) and Finish(reply), the latter on the pool.
template <class Handler, class Chunk, class Reply>
class ChunkReader final : public grpc::ServerReadReactor<Chunk> {
 public:
  template <class... Arguments>
  ChunkReader(grpc::CallbackServerContext* context, WorkPool& pool, Reply* reply, Arguments&&... arguments)
      : pool_(pool), reply_(reply), handler_(std::forward<Arguments>(arguments)...) {
    if (const auto status = CheckProtocol(context); !status.ok()) {
      this->Finish(status);
    } else {
      this->StartRead(&chunk_);
    }
  }
  void OnReadDone(bool ok) override {
    if (ok) {
      const auto status = Guarded([&] {
        RefuseUnknownFields(chunk_);
        handler_.Add(chunk_);
      });
      status.ok() ? this->StartRead(&chunk_) : this->Finish(status);
    } else if (cancelled_.load()) {
      this->Finish(grpc::Status::CANCELLED);
    } else if (!pool_.Post([this] { this->Finish(Guarded([&] { handler_.Finish(reply_); })); })) {
      this->Finish(QueueFull());
    }
  }
  void OnCancel() override { cancelled_ = true; }
  void OnDone() override { delete this; }

 private:
  WorkPool& pool_;
  Reply* reply_;
  Handler handler_;
  Chunk chunk_;
  std::atomic<bool> cancelled_{false};
};

// A stream of the newest: what a slow reader has not taken is replaced. Ends after a message for which `last` holds.
template <class Message>
class NewestWriter final : public grpc::ServerWriteReactor<Message> {
 public:
  explicit NewestWriter(std::function<bool(const Message&)> last)
      : shared_(std::make_shared<Shared>(last)), last_(std::move(last)) {
    shared_->writer = this;
  }
  // `watch` gets the function to call with each message; returns the number for `unwatch`.
  void Start(const std::function<uint64_t(std::function<void(Message)>)>& watch,
             std::function<void(uint64_t)> unwatch) {
    const auto shared = shared_;
    uint64_t number = 0;
    const auto status =
        Guarded([&] { number = watch([shared](Message message) { shared->Offer(std::move(message)); }); });
    std::unique_lock lock(shared->mutex);
    if (!status.ok()) {
      shared->End(status, lock);
      return;
    }
    if (!shared->writer) {  // over already
      lock.unlock();
      unwatch(number);
      return;
    }
    shared->unwatch = [unwatch, number] { unwatch(number); };
  }
  void Refuse(const grpc::Status& status) {
    std::unique_lock lock(shared_->mutex);
    shared_->End(status, lock);
  }
  void OnWriteDone(bool ok) override {
    std::unique_lock lock(shared_->mutex);
    shared_->writing = false;
    if (!ok || shared_->cancelled) return shared_->End(grpc::Status::CANCELLED, lock);
    if (last_(current_)) return shared_->End(grpc::Status::OK, lock);
    shared_->WriteNext();
  }
  void OnCancel() override {
    std::unique_lock lock(shared_->mutex);
    shared_->cancelled = true;
    if (!shared_->writing) shared_->End(grpc::Status::CANCELLED, lock);
  }
  void OnDone() override { delete this; }

 private:
  struct Shared {
    explicit Shared(std::function<bool(const Message&)> last) : newest(std::move(last)) {}
    std::mutex mutex;
    NewestWriter* writer = nullptr;  // null: over
    Newest<Message> newest;
    bool writing = false, cancelled = false;
    std::function<void()> unwatch;
    void Offer(Message message) {
      std::lock_guard lock(mutex);
      newest.Offer(std::move(message));
      if (!writing) WriteNext();
    }
    void WriteNext() {
      if (!writer || cancelled) return;
      auto message = newest.Take();
      if (!message) return;
      writer->current_ = std::move(*message);
      writing = true;
      writer->StartWrite(&writer->current_);
    }
    void End(const grpc::Status& status, std::unique_lock<std::mutex>& lock) {
      auto* mine = std::exchange(writer, nullptr);
      const auto leave = std::exchange(unwatch, nullptr);
      lock.unlock();
      if (leave) leave();
      if (mine) mine->Finish(status);
    }
  };
  const std::shared_ptr<Shared> shared_;
  const std::function<bool(const Message&)> last_;
  Message current_;
};

}  // namespace lodestar
