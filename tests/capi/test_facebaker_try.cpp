// facebaker.hpp in a host that is built without exceptions and RTTI. Fails by its exit status, naming the line.
#include <facebaker/facebaker.hpp>

#include <cmath>
#include <cstdio>
#include <cstring>

static_assert(!FACEBAKER_EXCEPTIONS);

namespace {

int failures = 0;

void expect(bool holds, int line) {
  if (holds) return;
  std::fprintf(stderr, "line %d does not hold: %s\n", line, fb_last_error());
  ++failures;
}
#define EXPECT(condition) expect(condition, __LINE__)

void pose(const facebaker::Model& model) {
  facebaker::Result<facebaker::Scratch> scratch = facebaker::Scratch::try_create(model);
  EXPECT(bool(scratch));
  std::vector<float> controls = model.rest_controls(), positions(3 * model.vertex_count());
  EXPECT(scratch->try_evaluate(controls.data(), positions.data()) == FB_OK);
  EXPECT(std::memcmp(positions.data(), model.rest_positions(), positions.size() * sizeof(float)) == 0);
  const facebaker::Result<std::uint32_t> jaw = model.try_find("jaw_open"), gone = model.try_find("jaw_opne");
  EXPECT(bool(jaw) && model.try_find_hash(fb_name_hash("jaw_open")).status() == FB_OK);
  EXPECT(!gone && gone.status() == FB_ERROR_NOT_FOUND && gone.message().find("jaw_open") != std::string::npos);
  EXPECT(model.try_control(*jaw)->maximum > 0 && !model.try_control(99));
  controls[*jaw] = NAN;
  EXPECT(scratch->try_evaluate(controls.data(), positions.data()) == FB_ERROR_NOT_FINITE);
  EXPECT(model.try_blend(controls.data(), nullptr, 0.5f, positions.data()) == FB_ERROR_NOT_FINITE);

  facebaker::Scratch moved = *std::move(scratch), other = *facebaker::Scratch::try_create(model, 2);
  other = std::move(moved);
  controls[*jaw] = 2;
  EXPECT(other.try_evaluate(controls.data(), positions.data()) == FB_OK && other.clamped_count() == 1);

  facebaker::ScratchPool pool(2);
  EXPECT(pool.try_add(model) == FB_OK);
  std::vector<float> pooled(positions.size());
  fb_batch_desc batch;
  fb_batch_desc_init(&batch);
  batch.poses = 1;
  batch.controls = controls.data();
  batch.control_floats = controls.size();
  batch.positions = pooled.data();
  batch.position_floats = pooled.size();
  const fb_many_item item = {model.get(), nullptr, &batch};
  fb_many_desc many;
  fb_many_desc_init(&many);
  many.items = &item;
  many.item_count = 1;
  EXPECT(pool.try_evaluate(many) == FB_OK);
  EXPECT(pooled == positions);
}

}  // namespace

int main() {
  const facebaker::Result<facebaker::Model> missing = facebaker::Model::try_load("/nowhere/face.fbk");
  EXPECT(!missing && missing.status() == FB_ERROR_NOT_FOUND);
  EXPECT(missing.message().find("/nowhere/face.fbk") != std::string::npos);
  facebaker::Result<facebaker::Model> model = facebaker::Model::try_load(FB_FIXTURE);
  EXPECT(bool(model) && model.status() == FB_OK && model.message().empty());
  if (model) pose(*model);
  return failures == 0 ? 0 : 1;
}
