#include "ranks/ranks_opener.h"

#include <facebaker/facebaker_bake.hpp>
#include <memory>

#include "base/status.h"
#include "commands/rig_options.h"
#include "ranks/rank_session.h"

namespace fb::tool {
namespace {

// A session for fb_spreader, which says when it is gone.
struct SpreadRanks {
  RankSession session;
  std::shared_ptr<bool> open;  // cleared at the end

  ~SpreadRanks() { *open = false; }
};

fb_status evaluate(void* user, fb_pose_block* block, char* message, std::uint32_t size) {
  std::string reason;
  const fb_status status = static_cast<SpreadRanks*>(user)->session.evaluate(*block, reason);
  if (size > 0) message[reason.copy(message, size - 1)] = '\0';
  return status;
}

facebaker::Source open(RankLink& link, std::uint32_t threads, const std::shared_ptr<bool>& busy,
                       const fb_source_desc& desc) {
  facebaker::Source local(desc);
  if (link.size() == 1 || *busy || !facebaker::SourceView(local).live()) return local;
  auto ranks = std::unique_ptr<SpreadRanks>(new SpreadRanks{{link, desc, local.get(), threads}, busy});
  *busy = true;
  fb_spreader spreader;
  fb_spreader_init(&spreader);
  spreader.user = ranks.get();
  spreader.evaluate = evaluate;
  spreader.close = [](void* user) { delete static_cast<SpreadRanks*>(user); };
  spreader.preferred_block = ranks->session.preferred_block();
  facebaker::Source spread = facebaker::Source::spread(std::move(local), spreader);
  ranks.release();  // closed with the source
  return spread;
}

}  // namespace

void open_on_ranks(RankLink& link, std::uint32_t threads) {
  set_source_opener([&link, threads, busy = std::make_shared<bool>(false)](const fb_source_desc& desc) {
    return open(link, threads, busy, desc);
  });
}

void end_ranks(RankLink& link) {
  for (std::size_t rank = 1; rank < link.size(); ++rank) link.send(rank, RankTag::end, {});
}

}  // namespace fb::tool
