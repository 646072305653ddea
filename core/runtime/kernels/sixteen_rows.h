// Panel products of kernels that compute 16 rows at a time, for one pose or for as many at once as fit the registers:
// included by kernel files inside an unnamed namespace, after sum_columns<poses>() and sum_quads<poses>() are defined,
// which leave the sums of pose p at sums[p].

template <int poses_at_once>
void column_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  std::int32_t sums[poses_at_once][16];
  for (std::size_t r = 0; r < panel.rows; r += 16)
    if (inputs.poses == 1) {
      sum_columns<1>(panel.digits + r, inputs, 0, sums);
      finish_rows(panel, output, 0, r, 16, sums[0]);
    } else {
      for (std::size_t pose = 0; pose < poses_per_block; pose += poses_at_once) {
        sum_columns<poses_at_once>(panel.digits + r, inputs, pose, sums);
        for (std::size_t p = 0; p < poses_at_once; ++p) finish_rows(panel, output, pose + p, r, 16, sums[p]);
      }
    }
}

template <int poses_at_once>
void quad_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  std::int32_t sums[poses_at_once][16];
  for (std::size_t r = 0; r < panel.rows; r += 16)
    if (inputs.poses == 1) {
      sum_quads<1>(panel.digits + 4 * r, panel.stride, inputs, 0, sums);
      finish_rows(panel, output, 0, r, 16, sums[0]);
    } else {
      for (std::size_t pose = 0; pose < poses_per_block; pose += poses_at_once) {
        sum_quads<poses_at_once>(panel.digits + 4 * r, panel.stride, inputs, pose, sums);
        for (std::size_t p = 0; p < poses_at_once; ++p) finish_rows(panel, output, pose + p, r, 16, sums[p]);
      }
    }
}
