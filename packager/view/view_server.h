// A small web server for one page on this machine: what it is, apart from the library that it is made with, which only
// facebaker-view links.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace fb::tool {

// Answers requests from 127.0.0.1 alone, and of pages that it served alone: a request that names another host, or comes
// from a page of another, is refused. What takes work, and may run a rig, is done for those alone who have the token of
// address(). It knows nothing of the disk: what was not added is not there. All of it is added before run().
class ViewServer {
 public:
  virtual ~ViewServer() = default;

  // "http://127.0.0.1:PORT/?token=TOKEN": the page takes the token from there, and sends it as "Authorization: Bearer
  // TOKEN". Another one each time.
  virtual std::string address() const = 0;

  // `path`: as in a request, from "/" on. Adding a path again replaces it.
  virtual void add_file(const std::string& path, const std::string& type, std::string bytes) = 0;
  // A file that is made at its first request and kept, for those with the token. An Error that `make` throws becomes an
  // answer with status 500 and its message; the next request tries again. One piece of work at a time is done, files
  // and calls alike, on a thread of the server.
  virtual void add_file(const std::string& path, const std::string& type, std::function<std::string()> make) = 0;
  // A file that is another one at each request, for those with the token: `make` takes no time, does not fail, and is
  // called on the thread of run().
  virtual void add_news(const std::string& path, const std::string& type, std::function<std::string()> make) = 0;
  // What answers a POST of those with the token: from its body, of 16 MiB at most, an application/octet-stream.
  virtual void add_call(const std::string& path, std::function<std::string(const std::string& body)> answer) = 0;

  // Serves until `stop` says so, which is asked about 20 times a second by the calling thread, and closes all
  // connections. False where work is still under way half a second later, such as a pose of a slow rig: then the
  // process may only end, without freeing the server or what the work uses.
  virtual bool run(const std::function<bool()>& stop) = 0;
};

// Binds a port of 127.0.0.1; 0: any that is free. Fails with io, naming the port, where it is taken.
using ServerOpener = std::function<std::unique_ptr<ViewServer>(int port)>;

}  // namespace fb::tool
