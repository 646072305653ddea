// Panel products of kernels that leave sums in memory: some rows of one pose at a time, or fewer of as many poses as
// fit the registers. Included by kernel files inside an unnamed namespace, after sum_columns<rows, poses>() and
// sum_quads<rows, poses>() are defined, which leave the sums of pose p at sums[p].

// sum(strip, first row, first pose, sums): the sums of a strip. A panel is stored with room for the last strip.
template <std::size_t rows, std::size_t poses, class Sum>
[[gnu::always_inline]] inline void for_strips(const Panel& panel, const PanelOutput& output, std::size_t all_poses,
                                              const Sum& sum) {
  std::int32_t sums[poses][rows];
  for (std::size_t r = 0; r < panel.rows; r += rows)
    for (std::size_t pose = 0; pose < all_poses; pose += poses) {
      sum(r, pose, sums);
      for (std::size_t p = 0; p < poses; ++p) finish_rows(panel, output, pose + p, r, rows, sums[p]);
    }
}

template <int rows, int block_rows, int poses>
void column_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  if (inputs.poses == 1)
    for_strips<rows, 1>(panel, output, 1, [&](std::size_t r, std::size_t pose, auto& sums) {
      sum_columns<rows, 1>(panel.digits + r, inputs, pose, sums);
    });
  else
    for_strips<block_rows, poses>(panel, output, poses_per_block, [&](std::size_t r, std::size_t pose, auto& sums) {
      sum_columns<block_rows, poses>(panel.digits + r, inputs, pose, sums);
    });
}

template <int rows, int block_rows, int poses>
void quad_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  if (inputs.poses == 1)
    for_strips<rows, 1>(panel, output, 1, [&](std::size_t r, std::size_t pose, auto& sums) {
      sum_quads<rows, 1>(panel.digits + quad_columns * r, panel.stride, inputs, pose, sums);
    });
  else
    for_strips<block_rows, poses>(panel, output, poses_per_block, [&](std::size_t r, std::size_t pose, auto& sums) {
      sum_quads<block_rows, poses>(panel.digits + quad_columns * r, panel.stride, inputs, pose, sums);
    });
}
