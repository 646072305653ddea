// How the time of a pose grows with vertices, with controls and with controls that are moved, on made-up faces of the
// proportions of a baked one. Prints comma-separated values; draws them on a page if given its name. With --vertices,
// only faces of so many vertices: 4,000,000 take 5 GB. With --archive it writes such a face, with a proof, for
// /usr/bin/time -v facebaker verify FACE.fbk.
//   bench_growth [PAGE.html]
//   bench_growth --vertices N...
//   bench_growth --archive N FACE.fbk
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <vector>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "base/status.h"
#include "base/thread_time.h"
#include "report/html.h"
#include "report/plot.h"
#include "runtime/evaluator.h"
#include "test_models.h"

namespace {

using namespace fb;
using namespace fb::runtime;
using namespace fb::tool;

constexpr std::uint32_t regions = 8, hidden = 112, outputs = 100, block_vertices = 64;
constexpr std::size_t most_frames = 48, rounds = 7;
constexpr std::size_t most_floats = 36'000'000;  // of the positions of all frames

struct Size {
  std::uint32_t vertices, controls, moved;
};

struct Cost {
  double one = 0, batch = 0;  // microseconds a pose: alone, and of a batch of all frames
  std::uint64_t bytes = 0;
};

// Baked order of the vertices of a grid: neighbours follow each other (Morton order), as in the blocks of a baked face.
std::vector<std::uint32_t> neighbours_together(std::uint32_t vertices, std::uint32_t across) {
  const auto spread = [](std::uint64_t bits) {
    std::uint64_t spread = 0;
    for (int bit = 0; bit < 24; ++bit) spread |= (bits >> bit & 1) << 2 * bit;
    return spread;
  };
  std::vector<std::uint32_t> order(vertices);
  std::iota(order.begin(), order.end(), 0u);
  std::vector<std::uint64_t> code(vertices);
  for (std::uint32_t v = 0; v < vertices; ++v) code[v] = spread(v % across) | spread(v / across) << 1;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return code[a] < code[b]; });
  return order;
}

// Every control has a curve of three knots, whose shapes reach a thirtieth of the face, and is an input of one of the
// regions, each of which has a network and a stretch of the face.
PackedModel made_up_face(const Size& size) {
  Random random(1);
  PackedModel model;
  const std::uint32_t across = static_cast<std::uint32_t>(std::sqrt(double(size.vertices)));
  model.rest = grid_mesh(across, size.vertices / across);
  const auto vertices = static_cast<std::uint32_t>(model.rest.vertex_count());
  model.order = neighbours_together(vertices, across);
  const std::uint32_t chunks = (vertices + block_vertices - 1) / block_vertices;
  std::vector<std::vector<std::uint32_t>> columns(chunks);
  for (std::uint32_t r = 0; r < regions; ++r) {
    const auto layer = [&](std::size_t inputs, std::uint32_t count, Activation activation, bool skip) {
      PackedLayer made =
          random_packed_layer(random, static_cast<std::uint32_t>(inputs), count, activation, skip, false);
      for (float& scale : made.scales) scale *= 4 / std::sqrt(float(inputs));
      return made;
    };
    PackedRegion region{"region " + std::to_string(r), {}, {}, {}};
    for (std::uint32_t c = r; c < size.controls; c += regions) region.features.push_back(4 * c);
    region.layers = {layer(region.features.size(), hidden, Activation::silu, false),
                     layer(hidden, hidden, Activation::silu, true), layer(hidden, hidden, Activation::silu, true),
                     layer(hidden, outputs, Activation::linear, false)};
    model.regions.push_back(std::move(region));
  }
  for (std::uint32_t c = 0; c < size.controls; ++c) {
    model.schema.controls.push_back({"control " + std::to_string(c), -1, 1, 0, ""});
    model.features.push_back({Feature::Kind::identity, c});
    const std::uint32_t reach = std::max(1u, chunks / 30), first = random.below(chunks);
    for (const float knot : {-0.5f, 0.0f, 0.5f}) {
      const auto column = static_cast<std::uint32_t>(model.direct.size());
      model.direct.push_back(static_cast<std::uint32_t>(model.features.size()));
      model.features.push_back({Feature::Kind::hat, c, knot < 0 ? -1.0f : 1.0f, std::fabs(knot), 2});
      for (std::uint32_t k = 0; k < reach; ++k) columns[(first + k) % chunks].push_back(column);
    }
  }
  const auto direct = static_cast<std::uint32_t>(model.direct.size());
  model.columns = direct + regions * outputs;
  for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) {
    std::vector<std::uint32_t>& used = columns[chunk];
    std::sort(used.begin(), used.end());
    const std::uint32_t region = chunk * regions / chunks;
    for (std::uint32_t o = 0; o < outputs; ++o)
      if (random.uniform() < 0.25f) used.push_back(direct + region * outputs + o);
    const std::uint32_t first = 3 * block_vertices * chunk, rows = std::min(3 * block_vertices, 3 * vertices - first);
    PackedRowBlock group{first, rows, {}, random_numbers(random, std::size_t(rows) * used.size(), largest_narrow)};
    for (const std::uint32_t column : used) group.columns.push_back({column, false, 0.01f / largest_narrow});
    model.row_blocks.push_back(std::move(group));
  }
  return model;
}

Cost measure(const Size& size) {
  const Evaluator face(made_up_face(size));
  const std::size_t frames = std::clamp<std::size_t>(most_floats / (3 * size.vertices), 4, most_frames);
  std::vector<float> controls(frames * size.controls), positions(frames * 3 * face.vertex_count());
  for (std::size_t frame = 0; frame < frames; ++frame)
    for (std::uint32_t m = 0; m < size.moved; ++m)
      controls[frame * size.controls + std::size_t(m) * size.controls / size.moved] =
          std::sin(0.05f * float(frame) + 2.4f * float(m));
  std::vector<Workspace> one;
  one.emplace_back(face);
  std::vector<double> alone, together;
  for (std::size_t round = 0; round < rounds; ++round) {
    for (std::size_t frame = 0; frame < frames; ++frame) {
      const double start = thread_time();
      face.evaluate(controls.data() + frame * size.controls, positions.data(), one[0]);
      alone.push_back(thread_time() - start);
    }
    const double start = thread_time();
    face.evaluate_batch({.poses = frames, .controls = controls, .positions = {positions.data(), positions.size()}}, one,
                        {1});
    together.push_back((thread_time() - start) / double(frames));
  }
  const auto median = [](std::vector<double>& times) {
    std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
    return times[times.size() / 2];
  };
  return {median(alone), median(together), face.bytes()};
}

std::string series(const char* name, const std::vector<Size>& sizes, std::uint32_t Size::*varied) {
  Plot plot{format("Microseconds a pose by %s", name), name, "us", {{"alone", {}, {}, 1}, {"in a batch", {}, {}, 2}}};
  plot.log_y = false;
  for (const Size& size : sizes) {
    const Cost cost = measure(size);
    std::printf("%s,%u,%u,%u,%.2f,%.2f,%llu\n", name, size.vertices, size.controls, size.moved, cost.one, cost.batch,
                static_cast<unsigned long long>(cost.bytes));
    for (Curve& curve : plot.curves) curve.x.push_back(double(size.*varied));
    plot.curves[0].y.push_back(cost.one);
    plot.curves[1].y.push_back(cost.batch);
  }
  return draw_plot(plot);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 4 && std::strcmp(argv[1], "--archive") == 0) {
    const PackedModel model = made_up_face({static_cast<std::uint32_t>(std::strtoul(argv[2], nullptr, 10)), 500, 100});
    write_file(argv[3], archive::write_archive(model, bake::make_proof(model, 1)));
    return 0;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::printf("varied,vertices,controls,moved controls,us alone,us in a batch of up to %zu,bytes of the model\n",
              most_frames);
  if (argc > 1 && std::strcmp(argv[1], "--vertices") == 0) {
    for (int i = 2; i < argc; ++i)
      series("vertices", {{static_cast<std::uint32_t>(std::strtoul(argv[i], nullptr, 10)), 500, 100}}, &Size::vertices);
    return 0;
  }
  Html page("The time of a pose");
  page.raw(series(
      "vertices",
      {{1500, 500, 100}, {3000, 500, 100}, {6000, 500, 100}, {12000, 500, 100}, {25000, 500, 100}, {50000, 500, 100}},
      &Size::vertices));
  page.raw(
      series("controls",
             {{6000, 50, 40}, {6000, 100, 40}, {6000, 250, 40}, {6000, 500, 40}, {6000, 1000, 40}, {6000, 2000, 40}},
             &Size::controls));
  page.raw(series("controls moved",
                  {{6000, 500, 0},
                   {6000, 500, 1},
                   {6000, 500, 25},
                   {6000, 500, 50},
                   {6000, 500, 100},
                   {6000, 500, 200},
                   {6000, 500, 500}},
                  &Size::moved));
  if (argc > 1) write_file(argv[1], page.page());
  return 0;
}
