// The paper's network in oneDNN beside the same network in Eigen, which `facebaker bench` compares a face with. Prints
// microseconds of processor time a pose on one thread, as comma-separated values. Built where CMake finds oneDNN
// (Debian: libdnnl-dev).
//   bench_onednn [CONTROLS VERTICES]
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <dnnl.hpp>
#include <unordered_map>
#include <vector>

#include "base/random.h"
#include "base/thread_time.h"
#include "bench/float_networks.h"

namespace {

using namespace fb;
using namespace fb::tool;
using dnnl::memory;

constexpr std::size_t batch = 256, poses = 200, rounds = 7;

// Layers as oneDNN lays them out for this processor and that many poses, one running into the next.
class LaidOut {
 public:
  LaidOut(const PaperNetwork& network, std::size_t count_of_poses) {
    const auto count = static_cast<memory::dim>(count_of_poses);
    const std::size_t last = network.layers().size() - 1;
    for (std::size_t l = 0; l <= last; ++l) {
      const PaperNetwork::Layer& layer = network.layers()[l];
      const auto inputs = static_cast<memory::dim>(layer.inputs), outputs = static_cast<memory::dim>(layer.outputs);
      const memory::desc from({count, inputs}, f32, memory::format_tag::ab);
      const memory::desc to({count, outputs}, f32, memory::format_tag::ab);
      const memory::desc bias({outputs}, f32, memory::format_tag::a);
      const bool bends = l + 2 <= last, skips = bends && l > 0;
      dnnl::post_ops after;
      if (bends) after.append_eltwise(1, dnnl::algorithm::eltwise_relu, 0, 0);
      if (skips) after.append_binary(dnnl::algorithm::binary_add, to);
      dnnl::primitive_attr attributes;
      attributes.set_post_ops(after);
      using Product = dnnl::inner_product_forward;
      const memory::desc any({outputs, inputs}, f32, memory::format_tag::any);
      const Product::primitive_desc description(Product::desc(dnnl::prop_kind::forward_inference, from, any, bias, to),
                                                attributes, engine_);
      memory given({{outputs, inputs}, f32, memory::format_tag::ba}, engine_, const_cast<float*>(layer.weights.data()));
      memory weights(description.weights_desc(), engine_);
      dnnl::reorder(given, weights).execute(stream_, given, weights);
      Step step{Product(description), {}};
      const memory x = l == 0 ? memory(from, engine_, nullptr) : steps_.back().arguments.at(DNNL_ARG_DST);
      step.arguments = {{DNNL_ARG_SRC, x},
                        {DNNL_ARG_WEIGHTS, weights},
                        {DNNL_ARG_BIAS, memory(bias, engine_, const_cast<float*>(layer.bias.data()))},
                        {DNNL_ARG_DST, l == last ? memory(to, engine_, nullptr) : memory(to, engine_)}};
      if (skips) step.arguments.insert({DNNL_ARG_ATTR_MULTIPLE_POST_OP(1) | DNNL_ARG_SRC_1, x});
      steps_.push_back(std::move(step));
    }
    stream_.wait();
  }

  void evaluate(const float* controls, float* positions) {
    steps_.front().arguments.at(DNNL_ARG_SRC).set_data_handle(const_cast<float*>(controls));
    steps_.back().arguments.at(DNNL_ARG_DST).set_data_handle(positions);
    for (Step& step : steps_) step.product.execute(stream_, step.arguments);
    stream_.wait();
  }

 private:
  static constexpr memory::data_type f32 = memory::data_type::f32;
  struct Step {
    dnnl::primitive product;
    std::unordered_map<int, memory> arguments;
  };
  dnnl::engine engine_{dnnl::engine::kind::cpu, 0};
  dnnl::stream stream_{engine_};
  std::vector<Step> steps_;
};

template <class Run>
double time_of(Run&& run) {
  const double start = thread_time();
  run();
  return thread_time() - start;
}

void print(const char* name, std::vector<double> times) {
  std::sort(times.begin(), times.end());
  std::printf("%s,%.1f,%.1f\n", name, times.front(), times[times.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t controls = argc > 2 ? std::strtoul(argv[1], nullptr, 10) : 500;
  const std::size_t vertices = argc > 2 ? std::strtoul(argv[2], nullptr, 10) : 6000;
  omp_set_num_threads(1);
  PaperNetwork in_eigen(controls, vertices);
  LaidOut alone(in_eigen, 1), together(in_eigen, batch);
  Random random(1);
  std::vector<float> inputs(batch * controls), expected(batch * 3 * vertices), found(batch * 3 * vertices);
  for (float& input : inputs) input = random.uniform();
  std::vector<double> one_eigen, one_onednn, batch_eigen, batch_onednn;
  for (std::size_t round = 0; round < rounds; ++round) {
    for (std::size_t p = 0; p < poses; ++p)
      one_eigen.push_back(time_of([&] { in_eigen.evaluate(1, inputs.data() + p * controls, expected.data()); }));
    for (std::size_t p = 0; p < poses; ++p)
      one_onednn.push_back(time_of([&] { alone.evaluate(inputs.data() + p * controls, found.data()); }));
    batch_eigen.push_back(time_of([&] { in_eigen.evaluate(batch, inputs.data(), expected.data()); }) / batch);
    batch_onednn.push_back(time_of([&] { together.evaluate(inputs.data(), found.data()); }) / batch);
  }
  float most = 0, size = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    most = std::max(most, std::abs(expected[i] - found[i]));
    size = std::max(size, std::abs(expected[i]));
  }
  const dnnl_version_t* version = dnnl::version();
  std::printf("oneDNN %d.%d.%d; largest difference %.1e of the largest number\n", version->major, version->minor,
              version->patch, double(most / size));
  std::printf("figure,least us,median us\n");
  print("Eigen", one_eigen);
  print("oneDNN", one_onednn);
  print("batch of 256: Eigen", batch_eigen);
  print("batch of 256: oneDNN", batch_onednn);
  return most <= 1e-3f * size ? 0 : 1;
}
