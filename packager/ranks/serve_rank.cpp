#include "ranks/serve_rank.h"

#include <unistd.h>

#include <algorithm>
#include <facebaker/facebaker_bake.hpp>
#include <filesystem>
#include <system_error>

#include "base/status.h"

namespace fb::tool {
namespace {

class RankService {
 public:
  RankService(RankLink& link, std::uint32_t threads) : link_(link), threads_(threads) {}
  void run();

 private:
  OpenAnswer open(const OpenRequest& request);
  Bytes evaluate(std::span<const std::byte> request);
  bool stop_requested();
  bool end_requested();

  RankLink& link_;
  const std::uint32_t threads_;
  std::optional<facebaker::Source> source_;
  PoseSizes sizes_;
  std::uint64_t number_ = 0;   // of the block of the request in work
  std::uint64_t stopped_ = 0;  // blocks up to this one are not wanted any more
  bool ended_ = false;
};

OpenAnswer RankService::open(const OpenRequest& request) {
  OpenAnswer answer;
  char machine[256] = {};
  if (::gethostname(machine, sizeof machine - 1) == 0) answer.machine = machine;
  std::vector<const char*> paths, joints;
  for (const std::string& path : request.paths) paths.push_back(path.c_str());
  for (const std::string& joint : request.control_joints) joints.push_back(joint.c_str());
  std::error_code unknown;
  const std::string host = std::filesystem::read_symlink("/proc/self/exe", unknown).string();
  fb_source_desc desc;
  fb_source_desc_init(&desc);
  desc.paths = paths.data();
  desc.path_count = static_cast<std::uint32_t>(paths.size());
  desc.workers = request.workers;
  desc.pose_seconds = request.pose_seconds;
  desc.joints = request.joints;
  desc.skip_broken = request.skip_broken;
  desc.control_joints = joints.data();
  desc.control_joint_count = static_cast<std::uint32_t>(joints.size());
  if (!unknown) desc.host = host.c_str();
  desc.callbacks.user = this;
  desc.callbacks.progress = [](void* service, const char*, std::uint64_t, std::uint64_t) -> std::int32_t {
    return static_cast<RankService*>(service)->end_requested();
  };
  try {
    source_.emplace(desc);
    const facebaker::SourceView view(*source_);
    sizes_ = sizes_of(view.info());
    answer.identity = view.info().identity;
    answer.poses_at_once = poses_at_once(view.info(), threads_);
  } catch (const facebaker::Error& error) {
    answer.failure = error.what();
  }
  return answer;
}

// Takes the wish to stop out of its turn.
bool RankService::stop_requested() {
  while (const auto message = link_.poll(RankTag::stop)) stopped_ = std::max(stopped_, block_number(message->bytes));
  return number_ <= stopped_;
}

bool RankService::end_requested() {
  ended_ = ended_ || link_.poll(RankTag::end).has_value();
  return ended_;
}

Bytes RankService::evaluate(std::span<const std::byte> request) {
  BlockAnswer answer(request, sizes_);
  number_ = block_number(request);
  if (stop_requested()) return answer.bytes(FB_ERROR_INTERRUPTED, "");
  fb_pose_block& block = answer.block();
  block.threads = threads_;
  block.callbacks.user = this;
  block.callbacks.progress = [](void* service, const char*, std::uint64_t, std::uint64_t) -> std::int32_t {
    return static_cast<RankService*>(service)->stop_requested();
  };
  const fb_status status = fb_source_evaluate_block(source_->get(), &block);
  return answer.bytes(status, status == FB_OK ? "" : fb_last_error());
}

void RankService::run() {
  while (!ended_) {
    const RankMessage message = wait_for_message(link_);
    switch (message.tag) {
      case RankTag::open:
        source_.reset();
        link_.send(0, RankTag::opened, bytes_of(open(open_request_from(message.bytes))));
        break;
      case RankTag::evaluate:
        link_.send(0, RankTag::answer, evaluate(message.bytes));
        break;
      case RankTag::stop:
        stopped_ = std::max(stopped_, block_number(message.bytes));
        break;
      case RankTag::close:
        source_.reset();
        break;
      case RankTag::end:
        ended_ = true;
        break;
      default:
        fail(Status::internal, "rank 0 sent a message of kind %d", static_cast<int>(message.tag));
    }
  }
}

}  // namespace

void serve_rank(RankLink& link, std::uint32_t threads) {
  RankService(link, threads).run();
}

std::uint32_t poses_at_once(const fb_source_info& info, std::uint32_t threads) {
  if (info.preferred_block > 0) return info.preferred_block;
  return (info.flags & FB_RIG_THREAD_SAFE) != 0 ? threads : 1;
}

}  // namespace fb::tool
