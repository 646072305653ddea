#include "commands/memory_end.h"

#include <unistd.h>

#include <new>
#include <string_view>

namespace fb::tool {

void end_where_memory_ends() {
  std::set_new_handler([] {
    constexpr std::string_view message = "facebaker: out of memory\n";
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, message.data(), message.size());
    ::_exit(1);
  });
}

}  // namespace fb::tool
