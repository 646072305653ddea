// Panel products of kernels that compute 32 rows of one pose at a time, so that indices and inputs are read half as
// often, or 16 rows of two poses: included by kernel files inside an unnamed namespace, after sum_columns<blocks of 16
// rows, poses>() and sum_quads<vectors of four rows, poses>() are defined, which leave the sums of pose p at sums[p].

using SumsOfTwo = std::int32_t[2][32];

void column_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  SumsOfTwo sums;
  std::size_t r = 0;
  if (inputs.poses == 1)
    for (; r + 16 < panel.rows; r += 32) {
      sum_columns<2, 1>(panel.digits + r, inputs, 0, sums);
      finish_rows(panel, output, 0, r, 32, sums[0]);
    }
  for (; r < panel.rows; r += 16)
    if (inputs.poses == 1) {
      sum_columns<1, 1>(panel.digits + r, inputs, 0, sums);
      finish_rows(panel, output, 0, r, 16, sums[0]);
    } else {
      for (std::size_t pose = 0; pose < poses_per_block; pose += 2) {
        sum_columns<1, 2>(panel.digits + r, inputs, pose, sums);
        for (std::size_t p = 0; p < 2; ++p) finish_rows(panel, output, pose + p, r, 16, sums[p]);
      }
    }
}

void quad_product(const Panel& panel, const PanelInputs& inputs, const PanelOutput& output) {
  SumsOfTwo sums;
  std::size_t r = 0;
  if (inputs.poses == 1)
    for (; r + 16 < panel.rows; r += 32) {
      sum_quads<8, 1>(panel.digits + 4 * r, panel.stride, inputs, 0, sums);
      finish_rows(panel, output, 0, r, 32, sums[0]);
    }
  for (; r < panel.rows; r += 16)
    if (inputs.poses == 1) {
      sum_quads<4, 1>(panel.digits + 4 * r, panel.stride, inputs, 0, sums);
      finish_rows(panel, output, 0, r, 16, sums[0]);
    } else {
      for (std::size_t pose = 0; pose < poses_per_block; pose += 2) {
        sum_quads<4, 2>(panel.digits + 4 * r, panel.stride, inputs, pose, sums);
        for (std::size_t p = 0; p < 2; ++p) finish_rows(panel, output, pose + p, r, 16, sums[p]);
      }
    }
}
